"""Notebooks show stations, runs and results by what they are."""

from unittest.mock import Mock

import pytest

from bt_manip.behaviours import ObjectExists
from bt_manip.bt import Sequence, Sleep
from bt_manip.cell import CellError, NoOpenGLError
from bt_manip.cell import cell as cell_module
from bt_manip.runner import html_table
from tests.support.notebook import built as built
from tests.support.notebook import station as station
from tests.support.notebook import words


def test_a_station_shows_robots_objects_and_a_picture(opengl, station):
    html = station._repr_html_()
    assert words(html) == "Station panda panda, computed_torque objects table, basket time 0.00 s"
    assert '<img src="data:image/png;base64,' in html
    assert words(html_table("A & B", {"x": "<1>", "none": None})) == "A & B x <1>"


def test_a_station_is_text_without_opengl(station, monkeypatch):
    monkeypatch.setattr(cell_module, "render", Mock(side_effect=NoOpenGLError("no backend")))
    assert issubclass(NoOpenGLError, CellError)
    assert "<img" not in station._repr_html_() and "table" in station._repr_html_()


def test_a_run_shows_its_request_and_its_tree(make_run):
    html = make_run(Sleep("rest", msec=30), seed=3)._repr_html_()
    assert words(html.partition("<svg")[0]) == (
        "Run tree test robots panda scene table_and_basket seed 3 cycle 1 of 1 time 0.00 s"
    )
    assert "Sleep &quot;rest&quot;" in html


def test_a_result_shows_status_reason_and_duration(station):
    result = station.run(Sequence(Sleep(msec=30), ObjectExists("check", object="cup")))
    assert result.duration == pytest.approx(0.030) and result.recording is None
    assert words(result._repr_html_()) == f"FAILURE reason {result.reason} duration 0.03 s"
