"""Faults of cameras disturb their frames, and are undone."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.bt import Sleep, Tree
from bt_manip.spatial import pose
from bt_manip_camera import faults
from bt_manip_camera.camera import DepthCamera
from bt_manip_camera.frame import difference
from bt_manip_stress import FaultContext, FaultError, parse_fault


def context(seed=1, **cameras):
    """Return the context of faults in a cell that has cameras only."""
    station = SimpleNamespace(cell=SimpleNamespace(entities=cameras))
    return FaultContext(station, None, None, np.random.default_rng(seed))


def test_a_moved_camera_is_believed_elsewhere():
    camera, fault = DepthCamera(calibration_distance=0.1), faults.CameraMoved()
    before = camera.miscalibration
    fault.start(context(eye=camera))
    off = difference(before, camera.miscalibration)
    assert off == pytest.approx((5e-3, np.radians(1.0)))
    fault.end()
    assert camera.miscalibration is before


def disturbances(fault, seeds=1, **parameters):
    """Give images of random depths and colours, and what faults of several seeds make of them."""
    rng, camera = np.random.default_rng(2), DepthCamera()
    depth, colour = rng.uniform(0.4, 0.9, (80, 120)), rng.integers(1, 255, (80, 120, 3), np.uint8)
    made = []
    for seed in range(seeds):
        one = fault(**parameters)
        one.start(context(seed, eye=camera))
        made.append(camera.disturb(depth, colour, rng))
        one.end()
        assert camera.disturb is None
    return depth, colour, made


@pytest.mark.parametrize(("given", "share"), [({}, 0.5), ({"share": 0.3}, 0.3)])
def test_a_share_of_the_pixels_is_lost_or_covered_from_a_random_side(given, share):
    depth, colour, ((lossy, seen),) = disturbances(faults.CameraDropout, **given)
    assert np.mean(lossy == 0.0) == pytest.approx(share, abs=0.02)
    np.testing.assert_array_equal(lossy[lossy > 0.0], depth[lossy > 0.0])
    np.testing.assert_array_equal(seen, colour)
    rows, columns = round(80 * share), round(120 * share)
    sides = [np.zeros((80, 120), bool) for _ in range(4)]
    sides[0][:rows] = sides[1][80 - rows :] = True
    sides[2][:, :columns] = sides[3][:, 120 - columns :] = True
    found = set()
    for near, grey in disturbances(faults.CameraCovered, 20, **given)[2]:
        (side,) = [i for i, hidden in enumerate(sides) if np.array_equal(near == 0.12, hidden)]
        np.testing.assert_array_equal(near[~sides[side]], depth[~sides[side]])
        expected = np.where(sides[side][..., None], 90, colour)
        np.testing.assert_array_equal(grey, expected)
        found.add(side)
    assert found == {0, 1, 2, 3}


@pytest.mark.parametrize("name", ["camera_dropout", "camera_covered"])
def test_a_share_is_from_0_to_1(parts, name):
    for share in ("0", "1"):
        planned = parse_fault(f"{name} at=Hover share={share}", parts.of("faults"))
        assert planned.parameters == {"share": float(share)}
    for share in ("-0.01", "1.01"):
        with pytest.raises(FaultError, match=f"share must be a number .* got '{share}'"):
            parse_fault(f"{name} at=Hover share={share}", parts.of("faults"))


def test_nothing_is_seen_in_the_dark():
    _, _, ((depth, colour),) = disturbances(faults.LightsOut)
    assert not depth.any() and not colour.any() and depth.shape == (80, 120)


def test_frames_arrive_late_from_the_named_camera_or_from_all():
    cameras = {"left": DepthCamera(), "right": DepthCamera(), "thing": None}
    for name, late in (("left", (0.3, 0.03)), ("right", (0.03, 0.3)), ("", (0.3, 0.3))):
        fault = faults.CameraDelay(camera=name)
        fault.start(context(**cameras))
        assert (cameras["left"].delay, cameras["right"].delay) == late
        fault.end()
        assert (cameras["left"].delay, cameras["right"].delay) == (0.03, 0.03)
    for name, given, why in (("up", cameras, "there is no camera 'up'"), ("", {}, "no camera")):
        with pytest.raises(FaultError, match=why):
            faults.LightsOut(camera=name).start(context(**given))


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
