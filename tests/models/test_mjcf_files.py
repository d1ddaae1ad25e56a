"""Broken MJCF, and files that no model should name, are one line each, at once."""

import os
import time

import pytest

from bt_manip.models import ModelError, check_mjcf

GOOD = '<mujoco>{}<worldbody><geom type="box" size=".1 .1 .1"/></worldbody></mujoco>'


@pytest.fixture
def model(tmp_path):
    """Write a model, beside a pipe and a folder with a mesh."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "good.stl").write_text("solid")
    (tmp_path / "part.xml").write_text('<mujoco><include file="model.xml"/></mujoco>')

    def write(text):
        (tmp_path / "model.xml").write_text(text)
        return tmp_path / "model.xml"

    return write


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "model.xml:1:1: not XML"),
        (GOOD[:30], "model.xml:1:31: not XML"),
        ("<robot/>", "expected <mujoco>, found <robot>"),
        ('<!DOCTYPE m [<!ENTITY a "a">]><mujoco/>', "DOCTYPE"),
        ("<mujoco>" + "<body>" * 1000, "Excessive depth"),
        (GOOD.format('<include file="/dev/zero"/>'), ":1: <include>: .* is not a regular file"),
        (GOOD.format('<include file="pipe"/>'), "file 'pipe' is not a regular file"),
        (GOOD.format('<include file="model.xml"/>'), "model.xml includes itself"),
        (GOOD.format('<include file="part.xml"/>'), "model.xml includes itself"),
        (
            GOOD.format('<asset><mesh name="m" file="/dev/zero"/></asset>'),
            "<mesh>: file '/dev/zero' is not a regular file",
        ),
        (
            GOOD.format('<asset><texture name="m" fileleft="meshes"/></asset>'),
            "<texture>: fileleft 'meshes' is a folder",
        ),
        (GOOD.format("").replace(".1 .1", ".1 nan"), "<geom>: size has NaN"),
    ],
)
def test_a_model_that_may_not_be_read_is_refused_with_its_line(model, text, message):
    start = time.monotonic()
    with pytest.raises(ModelError, match=message) as raised:
        check_mjcf(model(text))
    assert "\n" not in str(raised.value)
    assert time.monotonic() - start < 2.0


def test_good_models_and_missing_files_are_left_to_mujoco(model):
    for inside in (
        "",
        '<compiler meshdir="meshes"/><asset><mesh name="m" file="good.stl"/></asset>',
        '<asset><mesh name="m" file="missing.stl"/></asset>',
    ):
        check_mjcf(model(GOOD.format(inside)))


def test_a_model_of_absurd_size_is_refused_at_once(tmp_path):
    path = tmp_path / "wide.xml"
    attributes = " ".join(f"a{i}='1'" for i in range(1001))
    copies = "<replicate count='1000' offset='.1 0 0'>"
    for inside, message in (
        ("<geom size='.1'/>\n" * 3000, r"wide.xml:1\d\d\d: more than 2000 elements"),
        (f"<geom {attributes}/>", "more than 1000 attributes"),
        (f"{copies}{copies}<geom size='.1'/></replicate></replicate>", "more than 2000 elements"),
        ("<composite type='cable' count='3000 1 1' curve='s'/>", "more than 2000 elements"),
        ("<flexcomp name='f' type='grid' count='300 300 300'/>", "has more than 65536 points"),
        ("<hfield name='h' nrow='30000' ncol='30000'/>", "<hfield> has more than 16777216 points"),
    ):
        path.write_text(f"<mujoco><worldbody>{inside}</worldbody></mujoco>")
        with pytest.raises(ModelError, match=message):
            check_mjcf(path)
