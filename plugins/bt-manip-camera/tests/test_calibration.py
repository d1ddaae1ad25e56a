"""Where a camera is on a hand is found from the tag that it sees."""

import re
import tomllib
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

from bt_manip import build_station
from bt_manip.cell import CellError, looking_at
from bt_manip.scenes import SceneObject
from bt_manip_camera import commands
from bt_manip_camera.calibration import (
    HELD,
    View,
    calibrate,
    hold_tag,
    park_martin,
    take_views,
    view_of,
)
from bt_manip_camera.frame import Frame, difference
from bt_manip_camera.tags import SeenTag

SIZE = 0.06
T_GC = pin.SE3(pin.exp3(np.array([2.9, 0.3, -0.2])), np.array([0.07, 0.01, -0.06]))
T_WT = pin.SE3(pin.exp3(np.array([0.0, 0.1, 0.7])), np.array([0.4, 0.05, 1.0]))


@pytest.fixture
def library(opengl):
    pytest.importorskip("pupil_apriltags", reason="pupil-apriltags is not installed")


def views(number, noise=0.0, turns=1.0):
    """Give views of a tag, with noise of the corners as a fraction of the focal length."""
    rng, found = np.random.default_rng(0), []
    half = 0.5 * SIZE * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    for _ in range(number):
        turn = pin.exp3(rng.uniform(-0.6, 0.6, 3) * (turns, turns, 1.0))
        T_ct = pin.SE3(turn, np.array([*rng.uniform(-0.05, 0.05, 2), -rng.uniform(0.25, 0.4)]))
        points = half @ T_ct.rotation.T + T_ct.translation
        corners = points[:, :2] / -points[:, 2:] + rng.normal(0.0, noise, (4, 2))
        found.append(View(T_WT * T_ct.inverse() * T_GC.inverse(), T_ct, corners))
    return found


def test_exact_motions_give_the_exact_camera():
    seen = views(6)
    T_gc = park_martin([one.T_wg for one in seen], [one.T_ct for one in seen])
    assert difference(T_gc, T_GC) == pytest.approx((0.0, 0.0), abs=1e-9)
    found = calibrate(seen, SIZE)
    assert difference(found.T_gc, T_GC) == pytest.approx((0.0, 0.0), abs=1e-8)
    assert difference(found.T_wt, T_WT) == pytest.approx((0.0, 0.0), abs=1e-8)
    assert found.residual < 1e-9


def test_the_residual_is_the_noise_of_the_corners():
    found = calibrate(views(30, noise=4e-4), SIZE)
    assert found.residual == pytest.approx(4e-4 * np.sqrt(2), rel=0.15)
    assert difference(found.T_gc, T_GC)[0] < 1e-3


def test_too_few_views_and_one_axis_are_refused():
    with pytest.raises(CellError, match="needs at least 5 views of the tag, not 4"):
        calibrate(views(4), SIZE)
    with pytest.raises(CellError, match="rotations about at least two axes"):
        calibrate(views(8, turns=0.0), SIZE)


@pytest.mark.parametrize("degrees", [6.0, 8.0, 12.0])
def test_views_count_that_are_10_degrees_apart(degrees):
    turns = [pin.exp3(np.radians(degrees) * axis) for axis in (np.zeros(3), *np.eye(3)[:2])]
    tools = [pin.SE3(turn, turn @ (0.3, 0.2, -0.1)) for turn in turns]
    tags = [T_GC.inverse() * T_wg.inverse() * T_WT for T_wg in tools]
    if degrees > 10.0:
        assert difference(park_martin(tools, tags), T_GC) == pytest.approx((0.0, 0.0), abs=1e-9)
        tools, tags = tools[:2], tags[:2]
    with pytest.raises(CellError, match="rotations about at least two axes"):
        park_martin(tools, tags)  # the second and third are 1.4 times as far apart


def test_a_view_has_corners_from_the_centre_of_the_image_to_the_right_and_up():
    frame = Frame(np.zeros((40, 70)), np.zeros((40, 70, 3), np.uint8), 50.0, T_GC)
    corners = np.array([[3.0, 30.0], [60.0, 34.0], [65.0, 5.0], [1.0, 2.0]])
    seen = view_of(SeenTag(3, T_WT, np.zeros(2), corners), frame, T_GC * T_WT)
    assert seen.corners.ravel() == pytest.approx([-0.64, -0.2, 0.5, -0.28, 0.6, 0.3, -0.68, 0.36])
    assert (T_GC * seen.T_ct).isApprox(T_WT) and seen.T_wg.isApprox(T_GC * T_WT)


def test_a_fixed_camera_is_found_from_a_tag_on_the_hand(library, parts):
    scene, off = parts.scenes.create("table_with_tag"), {"calibration_distance": 5e-3}
    table = tuple(one for one in scene.objects if one.model == "table")
    T_wc = looking_at((1.1, 0.3, 1.7), (0.4, 0.0, 1.3))
    camera = SceneObject("depth_camera", "eye", T_wc, off)
    station = build_station(parts, scene=replace(scene, objects=(*table, camera)))
    camera, true = station.cell.find("eye"), station.cell.pose("eye")
    hold_tag(station, 3, SIZE)
    found = calibrate(list(take_views(station, camera, number=8, tag=3, size=SIZE)), SIZE)
    distance, angle = difference(found.T_gc, true)
    assert found.views == 8 and distance < 1e-3
    assert np.degrees(angle) < 0.2
    assert difference(found.T_wt, HELD)[0] < 1e-3


def test_the_commands_print_the_keys_of_the_camera_and_say_whether_they_fit(library, monkeypatch):
    monkeypatch.setattr(commands, "find_calibration", cache(commands.find_calibration))
    ran = CliRunner().invoke(commands.camera, ["calibrate", "--views", "8"], standalone_mode=False)
    keys = tomllib.loads(ran.output)
    np.testing.assert_allclose(keys["position"], (0.07, 0.0, -0.06), atol=1e-3)
    off = np.diag([1.0, -1.0, -1.0]) @ pin.rpy.rpyToMatrix(np.array(keys["rpy"]))
    assert np.degrees(np.linalg.norm(pin.log3(off))) < 0.2  # it looks along the tool's z axis
    assert re.search(r"# (4.9|5.[01]) mm and (0.9|1.0). degrees from the description", ran.output)
    ran = CliRunner().invoke(commands.camera, ["check", "--views", "8"], standalone_mode=False)
    assert ran.return_value == 1
    assert ran.output.startswith("it does not fit any more: ")


@pytest.mark.parametrize(
    ("distance", "degrees", "fits"), [(1e-3, 0.2, True), (3e-3, 0.2, False), (1e-3, 0.7, False)]
)
def test_a_description_fits_within_2_mm_and_half_a_degree(monkeypatch, distance, degrees, fits):
    off = pin.SE3(pin.exp3(np.array([0.0, np.radians(degrees), 0.0])), np.array([distance, 0, 0]))
    found = SimpleNamespace(T_gc=T_GC * off, views=6)
    monkeypatch.setattr(commands, "find_calibration", lambda **options: (found, T_GC, 0.1))
    ran = CliRunner().invoke(commands.camera, ["check"], standalone_mode=False)
    assert ran.return_value == (0 if fits else 1)
    assert ran.output.startswith("it fits: " if fits else "it does not fit any more: ")
