"""Panels of plugins are shown, and isolated: one that raises costs a warning, the run goes on."""

import json
import re
from contextlib import closing
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from bt_manip.bt import Sleep
from bt_manip.plugins import load_plugins
from bt_manip_view import Page
from bt_manip_view.page.plugin_panels import page_panels

VIEW = [EntryPoint("view", "bt_manip_view.plugin", "bt_manip")]
"""The entry point of this package."""

README = Path(__file__).resolve().parents[2] / "README.md"

PLUGIN = """
from bt_manip import hookimpl
from bt_manip_view import Panel

class Broken(Panel):
    {}

@hookimpl
def register_panels(register):
    register("broken", Broken)
"""


@pytest.fixture
def watched_run(make_run, tmp_path, capsys, monkeypatch):
    """Execute a run with the panels of a plugin; return station, elements by kind, and warnings."""

    def execute(code: str):
        (tmp_path / "a_panel.py").write_text(code)
        monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(tmp_path))
        plugins = load_plugins(entry_points=VIEW, warn=pytest.fail)
        run = make_run(Sleep(msec=50))
        with closing(Page(page_panels(plugins), port=0, speed=None)) as page:
            run.execute([page])
        assert run.station.cell.time == pytest.approx(0.06)
        elements = [change[3:] for change in json.loads(page.gui.snapshot()[1])[1:]]
        return run.station, elements, capsys.readouterr().err.splitlines()

    return execute


def test_the_panel_of_the_readme_is_on_the_page(watched_run):
    (code,) = re.findall(r"```python\n(.*?register_panels.*?)```", README.read_text(), re.DOTALL)
    station, elements, warnings = watched_run(code)
    (number,) = [props for _, props in elements if props.get("label") == "Height [m]"]
    assert number["value"] == pytest.approx(station.robot.tool_pose.translation[2], abs=1e-3)
    assert not warnings


@pytest.mark.parametrize("method", ["start", "handle", "end_tick", "draw", "close"])
def test_a_panel_that_raises_is_not_called_again(watched_run, method):
    body = f"def {method}(self, *rest): raise ValueError('too hot')"
    _, _, (warning,) = watched_run(PLUGIN.format(body))
    assert warning.startswith("Warning: panel 'broken' of plugin 'a_panel'")
    assert "is not called again, the run continues: ValueError: too hot" in warning


def test_a_panel_that_cannot_be_made_is_left_out(watched_run):
    body = "def __init__(self, page): raise ValueError('too hot')"
    _, elements, (warning,) = watched_run(PLUGIN.format(body))
    assert "is left out: panel 'broken' cannot be made: ValueError: too hot" in warning
    assert {kind for kind, _ in elements} >= {"tree", "timeline", "log", "blackboard", "plot"}
