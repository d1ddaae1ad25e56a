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

from bt_manip.cell import CellError, looking_at
from bt_manip.exceptions import MotionError
from bt_manip.scenes import SceneObject
from bt_manip.spatial import pose
from bt_manip_camera import calibration, commands
from bt_manip_camera.calibration import HELD, View, calibrate, park_martin, take_views, view_of
from bt_manip_camera.frame import Frame, difference
from bt_manip_camera.tags import SeenTag

SIZE, hold = 0.06, calibration.hold_tag
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
    seen = views(5)
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


T_WG = pin.SE3(pin.exp3(np.array([0.3, 2.8, 0.1])), np.array([0.3, 0.1, 0.4]))
T_WC = looking_at((1.1, 0.3, 1.7), (0.4, 0.0, 1.3))


def sampled(mount, unreached=2000, **options):
    """Give the poses that an arm is to reach, which it does after some, and the views."""
    tried = []

    def move(poses):
        tried.extend(poses)
        if len(tried) <= unreached:
            raise MotionError("too far", reason="")

    model = SimpleNamespace(pose=lambda q: T_WG)
    arm = SimpleNamespace(model=model, move_to_pose=move, at_rest=True)
    one = SimpleNamespace(arm=arm, robot=SimpleNamespace(q=None))
    station = SimpleNamespace(
        first=one, robots={"arm": one}, rng=np.random.default_rng(0), step_until=lambda *_, **__: 0
    )
    T_wc, images = T_WG * T_GC if mount else T_WC, (np.zeros((480, 640)), np.zeros((480, 640, 3)))
    camera = SimpleNamespace(mount=mount, width=640, height=480, focal_length=500.0)
    camera.expose = lambda *_: Frame(*images, 500.0, T_wc)
    return tried, list(take_views(station, camera, size=SIZE, **options))


def check_all_of(values, low, high):
    """Check that many random values are spread evenly from a lower to an upper bound."""
    assert len(values) == 2000 and (values >= low).all() and (values <= high).all()
    found = np.quantile(values, (0.0, 1 / 3, 2 / 3, 1.0))
    np.testing.assert_allclose(found, np.linspace(low, high, 4), atol=0.03 * (high - low))


def turns(poses, axis):
    """Give the angles of an axis of poses about the vertical."""
    x, y, _ = np.array([T.rotation[:, axis] for T in poses]).T
    return np.arctan2(y, x)


def test_a_tag_on_the_hand_is_held_in_the_image_at_all_distances_and_tilts():
    tried, found = sampled("", number=100, tag=3)
    poses = [T_WC.actInv(T_wg) * HELD for T_wg in tried]
    x, y, z = np.array([T.translation for T in poses]).T
    check_all_of(-z, 0.3, 1.0)
    check_all_of(x / -z, -0.35 * 640 / 500, 0.35 * 640 / 500)
    check_all_of(y / -z, -0.35 * 480 / 500, 0.35 * 480 / 500)
    tilts = np.arccos([T.rotation[2, 2] for T in poses])
    check_all_of(np.degrees(tilts), 5.0, 40.0)
    check_all_of(turns(poses, 2), -np.pi, np.pi)
    check_all_of(turns(poses, 0), -np.pi, np.pi)
    assert not found


def test_a_camera_on_the_hand_looks_at_the_tag_from_above_at_all_distances_and_turns():
    at = np.array([0.4, 0.05, 1.0])
    poses = [T_wg * T_GC for T_wg in sampled("arm", number=100, tag=3, at=at)[0]]
    away = np.array([T.translation for T in poses]) - at
    distance = np.linalg.norm(away, axis=1)
    check_all_of(distance, 0.25, 0.4)
    check_all_of(np.degrees(np.arcsin(away[:, 2] / distance)), 45.0, 85.0)
    check_all_of(np.arctan2(away[:, 1], away[:, 0]), -np.pi, np.pi)
    axes = np.array([T.rotation[:, 2] for T in poses])  # it looks along -z
    met = away - axes * (away[:, 2] / axes[:, 2])[:, None]
    check_all_of(met[:, 0], -0.04, 0.04)
    check_all_of(met[:, 1], -0.04, 0.04)
    check_all_of(turns(poses, 0), -np.pi, np.pi)


@pytest.mark.parametrize("mount", ["", "arm"])
def test_views_are_of_the_tag_where_it_is_reached_and_seen_until_there_are_enough(
    monkeypatch, mount
):
    tags = [SeenTag(number, T_WT, np.zeros(2), np.ones((4, 2))) for number in (2, 3)]
    shown = iter([tags, tags[:1], tags, tags, tags, tags])
    monkeypatch.setattr(calibration, "detect_tags", lambda frame, size: next(shown))
    tried, found = sampled(mount, 7, number=3, tag=3, at=T_WT.translation)
    assert len(tried) == 11 and len(found) == 3 and len([*shown]) == 2
    for view in found:
        assert view.T_wg.isApprox(T_WG if mount else T_WG.inverse())
        assert view.T_ct.isApprox((T_WG * T_GC if mount else T_WC).actInv(T_WT))


def test_a_fixed_camera_is_found_from_a_tag_on_the_hand(library, parts, monkeypatch):
    scene, off = parts.scenes.create("table_with_tag"), {"calibration_distance": 5e-3}
    table = tuple(one for one in scene.objects if one.model == "table")
    scene = replace(scene, objects=(*table, SceneObject("depth_camera", "eye", T_WC, off)))
    held = []
    monkeypatch.setattr(calibration, "hold_tag", lambda *given: held.append(given) or hold(*given))
    found, believed, pixels = commands.find_calibration(scene, "panda", "", views=5, seed=0)
    distance, angle = difference(found.T_gc, T_WC)
    assert found.views == 5 and distance < 1e-3 and np.degrees(angle) < 0.2
    assert difference(believed, T_WC) == pytest.approx((5e-3, 0.0), abs=1e-9)
    assert found.T_wt.isApprox(pose((0.07, 0.0, -0.05), (0.5,) * 4), 5e-3)
    assert pixels == pytest.approx(found.residual * 240.0 / np.tan(np.radians(25.0)))
    assert pixels < 1.0 and held[0][1:] == (0, 0.06)
    with pytest.raises(CellError, match="has one april_tag, not 0"):
        commands.find_calibration("table_seen", "panda", "", views=5, seed=0)


def test_the_commands_print_the_keys_of_the_camera_and_say_whether_they_fit(library, monkeypatch):
    monkeypatch.setattr(commands, "find_calibration", cache(commands.find_calibration))
    ran = CliRunner().invoke(commands.camera, ["calibrate", "--views", "6"], standalone_mode=False)
    keys = tomllib.loads(ran.output)
    np.testing.assert_allclose(keys["position"], (0.07, 0.0, -0.06), atol=1e-3)
    off = np.diag([1.0, -1.0, -1.0]) @ pin.rpy.rpyToMatrix(np.array(keys["rpy"]))
    assert np.degrees(np.linalg.norm(pin.log3(off))) < 0.2  # it looks along the tool's z axis
    assert re.search(r"# (4.9|5.[01]) mm and (0.9|1.0). degrees from the description", ran.output)
    ran = CliRunner().invoke(commands.camera, ["check", "--views", "6"], standalone_mode=False)
    assert ran.return_value == 1
    assert ran.output.startswith("it does not fit any more: ")


@pytest.mark.parametrize(
    ("distance", "degrees", "fits"),
    [(1.9e-3, 0.49, True), (2.1e-3, 0.2, False), (1e-3, 0.51, False)],
)
def test_a_description_fits_within_2_mm_and_half_a_degree(monkeypatch, distance, degrees, fits):
    off = pin.SE3(pin.exp3(np.array([0.0, np.radians(degrees), 0.0])), np.array([distance, 0, 0]))
    found, given = SimpleNamespace(T_gc=T_GC * off, views=6), {}
    monkeypatch.setattr(
        commands, "find_calibration", lambda **options: given.update(options) or (found, T_GC, 0.1)
    )
    ran = CliRunner().invoke(commands.camera, ["check"], standalone_mode=False)
    assert ran.return_value == (0 if fits else 1)
    assert ran.output.startswith("it fits: " if fits else "it does not fit any more: ")
    expected = {"scene": "table_with_tag", "robot": "panda", "name": "", "views": 12, "seed": 0}
    assert given == expected
    assert CliRunner().invoke(commands.camera, ["check", "--views", "4"]).exit_code == 2
