"""Depth cameras see what is there, with the errors that they declare."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.cell import Cell, CellError, NoOpenGLError, looking_at
from bt_manip.cell.objects import ConvexMesh, Cube
from bt_manip.spatial import pose
from bt_manip_camera.camera import DepthCamera

PERFECT = dict.fromkeys(("noise", "smooth_noise", "dropout"), 0.0)


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def test_depth_is_what_rays_meet_and_colour_that_of_a_camera_of_the_cell(see, rng, parts):
    cell, camera = see(width=160, height=120, **PERFECT)
    frame, geom, gaps = camera.expose(rng), np.zeros(1, np.int32), []
    rays = frame.rays() @ frame.T_wc.rotation.T
    for v, u in rng.integers(0, (120, 160), (60, 2)):
        away = mujoco.mj_ray(
            cell.model, cell.data, frame.T_wc.translation, rays[v, u], None, 1, -1, geom
        )
        gaps.append(abs(frame.depth[v, u] - away))  # of rays that are 1 deep
    assert np.mean(np.array(gaps) < 5e-4) > 0.95  # the others are at edges
    camera.close()  # the next image has a new renderer
    camera.disturb = lambda depth, colour, rng: (2.0 * depth, 255 - colour)
    disturbed = camera.expose(rng)
    np.testing.assert_array_equal(disturbed.depth, 2.0 * frame.depth)
    np.testing.assert_array_equal(disturbed.colour, 255 - frame.colour)
    other = parts.objects.create("camera", width=160, height=120, fovy=50.0)
    cell.add(other, cell.pose("camera"), name="other", free=False)
    np.testing.assert_array_equal(frame.colour, other.rgb())
    other.close()


def test_a_camera_on_a_hand_sees_what_a_fixed_one_at_its_pose_does(opengl):
    station = build_station()
    cell, arm = station.cell, station.arm
    T_tc = looking_at((0.05, 0.0, -0.1), (0.0, 0.0, 0.2))
    size = {"width": 160, "height": 120}
    hand = DepthCamera(mount=station.first.name, **size, **PERFECT)
    cell.add(hand, T_tc, name="hand_camera", free=False)
    station.robot.set_configuration(arm.q + 0.1)
    cell.step(1)
    colour, depth, T_wc = hand.render(station.robots)
    assert T_wc.isApprox(arm.model.pose(station.robot.q) * T_tc)
    fixed = DepthCamera(**size, **PERFECT)
    before = cell.data.qpos.copy()
    cell.add(fixed, T_wc, name="fixed", free=False)
    np.testing.assert_array_equal(cell.data.qpos, before)
    other_colour, other_depth, _ = fixed.render()
    assert np.mean(colour != other_colour) < 0.01  # rounding at edges
    assert np.median(np.abs(depth - other_depth)) < 1e-5
    with pytest.raises(CellError, match="mounted on 'panda', which is no robot of this cell"):
        hand.render({})


PROCESS = """
import hashlib, numpy as np
from bt_manip.cell import Cell, Table
from bt_manip.spatial import pose
from bt_manip_camera.camera import DepthCamera
cell, camera = Cell(), DepthCamera()
cell.add(Table(), pose((0.0, 0.0, 0.0)), free=False)
cell.add(camera, pose((0.0, 0.0, 1.6)), free=False)
frame = camera.expose(np.random.default_rng(0))
digest = hashlib.sha256(frame.depth.tobytes() + frame.colour.tobytes()).hexdigest()
"""


def test_processes_see_the_same_bits(opengl):
    code = f"{PROCESS}print(digest)"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    names = {}
    exec(PROCESS, names)
    assert other.stdout == f"{names['digest']}\n"


def test_the_renderer_is_kept_when_objects_come_and_go(see):
    cell, camera = see(width=80, height=60)
    fresh = DepthCamera(width=80, height=60)
    seen, kept = [camera.render()[0]], []
    for _ in range(2):
        cell.add(Cube(size=0.04), pose((0.1, 0.1, 1.2)), name="another")
        seen.append(camera.render()[0])
        cell.remove("another")
        seen.append(camera.render()[0])
        kept.append(list(camera.contexts.values()))
    assert kept[0] == kept[1] and len(kept[0]) == 2  # with and without its texture
    cell.add(ConvexMesh(), pose((0.1, 0.1, 1.2)), name="mesh")
    camera.render()
    assert len(camera.contexts) == 2  # the one without the cube is gone
    cell.remove("mesh")
    seen.append(camera.render()[0])
    np.testing.assert_array_equal(seen[0], seen[-1])
    assert not np.array_equal(seen[0], seen[1])
    cell.add(fresh, cell.pose("camera"), name="fresh", free=False)
    np.testing.assert_array_equal(fresh.render()[0], seen[-1])


def test_frames_begin_at_multiples_of_their_period():
    camera = DepthCamera(rate=30.0)
    assert camera.next_exposure(0.0) == 0.0
    assert camera.next_exposure(0.01) == pytest.approx(1 / 30)
    assert camera.next_exposure(1 / 30) == pytest.approx(1 / 30)
    assert DepthCamera(rate=0.5).next_exposure(0.1) == pytest.approx(2.0)


def test_a_camera_outside_a_cell_and_without_opengl_says_so(monkeypatch, rng):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    cell, camera = Cell(), DepthCamera()
    with pytest.raises(CellError, match="camera 'depth_camera' is not in a cell yet"):
        camera.expose(rng)
    cell.add(camera, pose((0.0, 0.0, 1.0)), name="camera", free=False)
    with pytest.raises(
        NoOpenGLError, match="nothing can be drawn with MUJOCO_GL disable; .*MUJOCO_GL=egl"
    ):
        camera.expose(rng)
