"""Faults of cameras disturb their frames, and are undone."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.bt import Sleep, Tree
from bt_manip.spatial import pose
from bt_manip_camera import faults
from bt_manip_camera.camera import DepthCamera
from bt_manip_camera.estimation import KnownObject, NotSeenError, estimate_pose
from bt_manip_stress import FaultContext, FaultError, parse_fault

CUBE = KnownObject("cube", "box", (0.05, 0.05, 0.05))


@pytest.fixture
def disturbed(see):
    """Give the frames of a camera without, with and after a fault."""

    def disturb(fault, width=320, height=240):
        cell, camera = see(width=width, height=height)
        station = _Station(cell)
        frames = [camera.expose(np.random.default_rng(0))]
        fault.start(FaultContext(station, None, None, np.random.default_rng(1)))
        frames.append(camera.expose(np.random.default_rng(0)))
        fault.end()
        frames.append(camera.expose(np.random.default_rng(0)))
        np.testing.assert_array_equal(frames[0].depth, frames[2].depth)
        assert frames[0].T_wc == frames[2].T_wc
        return frames[:2]

    return disturb


class _Station:
    """As much of a station as faults of cameras read."""

    def __init__(self, cell):
        self.cell = cell


def test_a_moved_camera_is_believed_elsewhere(disturbed):
    before, after = disturbed(faults.CameraMoved())
    off = before.T_wc.actInv(after.T_wc)
    assert np.linalg.norm(off.translation) == pytest.approx(5e-3)
    assert np.degrees(np.arccos((np.trace(off.rotation) - 1) / 2)) == pytest.approx(1.0)
    np.testing.assert_array_equal(before.depth, after.depth)


def test_half_of_the_pixels_are_lost_and_the_cube_is_seen(disturbed):
    before, after = disturbed(faults.CameraDropout(share=0.5), 640, 480)
    assert np.mean(after.depth > 0.0) == pytest.approx(0.5 * np.mean(before.depth > 0.0), rel=0.02)
    gap = estimate_pose(after, CUBE).T_wo.translation - estimate_pose(before, CUBE).T_wo.translation
    assert np.linalg.norm(gap) < 2e-3


@pytest.mark.parametrize("name", ["camera_dropout", "camera_covered"])
def test_a_share_is_from_0_to_1(parts, name):
    for share in ("0", "1"):
        planned = parse_fault(f"{name} at=Hover share={share}", parts.of("faults"))
        assert planned.parameters == {"share": float(share)}
    for share in ("-0.01", "1.01"):
        with pytest.raises(FaultError, match=f"share must be a number .* got '{share}'"):
            parse_fault(f"{name} at=Hover share={share}", parts.of("faults"))


def test_what_is_covered_is_not_seen(disturbed):
    before, after = disturbed(faults.CameraCovered(share=0.5))
    assert np.mean(after.depth == faults.NEAR) == pytest.approx(0.5)
    estimate_pose(before, CUBE, surface=1.015)
    with pytest.raises(NotSeenError):
        estimate_pose(disturbed(faults.CameraCovered(share=0.95))[1], CUBE, surface=1.015)


def test_nothing_is_seen_in_the_dark(disturbed):
    _, after = disturbed(faults.LightsOut())
    assert not after.depth.any() and not after.colour.any()
    with pytest.raises(NotSeenError):
        estimate_pose(after, CUBE)


def test_frames_arrive_late_from_a_camera_that_is_there(see):
    cell, camera = see()
    context = FaultContext(_Station(cell), None, None, np.random.default_rng(1))
    fault = faults.CameraDelay()
    fault.start(context)
    assert camera.delay == 0.3
    fault.end()
    assert camera.delay == 0.03
    with pytest.raises(FaultError, match="there is no camera 'left'"):
        faults.LightsOut(camera="left").start(context)


def test_a_look_alike_stands_within_reach(opengl, parts):
    station = build_station(parts, scene="table_seen")
    cube = station.models.create("cube", size=0.07)
    station.cell.add(cube, pose((0.3, 0.0, 1.05)), name="cube")
    tree = Tree(Sleep("rest", msec=100), clock=station.clock)
    fault = faults.LookAlike()
    fault.start(FaultContext(station, tree, tree.root, np.random.default_rng(1)))
    assert station.cell.find("cube_alike").parameters["size"] == 0.07
    assert station.first.reach.reaches(station.cell, "cube_alike")
    fault.end()
    assert "cube_alike" not in station.cell.entities


def test_a_fault_is_that_of_the_named_camera_or_of_all():
    left, right = DepthCamera(), DepthCamera()
    cell = SimpleNamespace(entities={"left": left, "right": right, "thing": None})
    for name, expected in (("left", [left]), ("right", [right]), ("", [left, right])):
        fault = faults.CameraDelay(camera=name)
        fault.context = FaultContext(_Station(cell), None, None, None)
        assert fault.cameras() == expected
