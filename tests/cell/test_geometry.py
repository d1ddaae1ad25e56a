"""Poses inside an entity, compared with MuJoCo's kinematics."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Basket, Cell, Cube, body_poses, centre_of_mass, extent, geom_pose
from bt_manip.cell.geometry import nearest_free
from bt_manip.cell.objects import Can, Sphere
from bt_manip.spatial import pose

CABINET = """<mujoco><compiler angle="radian"/><worldbody>
  <body name="other" pos="1 0 0"><geom size=".1"/></body>
  <body name="cabinet" pos="{at}" quat="{quat}">{free}
    <geom size=".1"/>
    <body name="drawer" pos=".1 .2 .3" quat=".5 -.5 .5 .5">
      <joint type="slide" axis=".6 0 .8" pos=".1 0 0" ref=".05"/>
      <geom type="box" size=".1 .2 .3" pos=".01 .02 .03" quat=".8 .6 0 0"/>
      <body name="lid" pos="0 .1 0">
        <joint axis="0 0 1" pos=".1 .2 0"/><joint axis="0 1 0" pos="0 -.1 .2" ref=".3"/>
        <geom size=".05" pos=".3 .1 -.2"/>
        <body name="knob" pos=".1 0 .1"><joint type="ball" pos="0 .03 .01"/>
          <geom type="capsule" size=".02 .1" pos=".04 0 .1"/></body></body></body></body>
</worldbody></mujoco>"""


def cabinet(at: str = "0 0 0", quat: str = "1 0 0 0", free: str = "") -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(CABINET.format(at=at, quat=quat, free=free))


@pytest.mark.parametrize("free", ["", "<freejoint/>"])
def test_poses_inside_an_entity_are_those_of_mujoco(free, rng):
    model = cabinet("1 2 3", ".1 .5 -.3 .7", free)
    data = mujoco.MjData(model)
    data.qpos[:] += rng.normal(size=model.nq)
    mujoco.mj_kinematics(model, data)
    root = model.body("cabinet").id
    poses = body_poses(model, root, data.qpos)
    T_wr = pin.SE3(data.xmat[root].reshape(3, 3), data.xpos[root])
    assert list(poses) == [2, 3, 4, 5]
    for body, T_rb in poses.items():
        T_wb = T_wr * T_rb
        assert data.xpos[body] == pytest.approx(T_wb.translation, abs=1e-12)
        assert data.xmat[body] == pytest.approx(T_wb.rotation.ravel(), abs=1e-12)
    for geom in range(1, model.ngeom):
        T_wg = T_wr * geom_pose(model, poses, geom)
        assert data.geom_xpos[geom] == pytest.approx(T_wg.translation, abs=1e-12)
        assert data.geom_xmat[geom] == pytest.approx(T_wg.rotation.ravel(), abs=1e-12)


def test_poses_inside_an_entity_have_the_same_bits_wherever_it_is(rng):
    def bits(model, qpos):
        poses = body_poses(model, model.body("cabinet").id, qpos)
        geoms = [geom_pose(model, poses, geom) for geom in range(1, model.ngeom)]
        return [T.homogeneous.tobytes() for T in (*poses.values(), *geoms)]

    inner = rng.normal(size=7)
    here, there = cabinet(), cabinet("1 2 3", ".1 .5 -.3 .7", "<freejoint/>")
    assert bits(here, inner) == bits(there, np.concatenate([rng.normal(size=7), inner]))
    assert bits(here, inner) != bits(here, inner + 1e-9)


@pytest.mark.parametrize("entity", [Cube, Basket])
def test_the_centre_of_mass_is_that_of_mujoco_and_does_not_depend_on_the_pose(entity):
    cell, found = Cell(), set()
    for at in ((0.0, 0.0, 1.0), (0.7, -0.3, 1.3)):
        name = cell.add(entity(), pose(at, (0.1, 0.5, -0.3, 0.7)), name="thing")
        com = centre_of_mass(cell, name)
        expected = cell.data.subtree_com[cell.body_id(name)]
        assert cell.pose(name).act(com) == pytest.approx(expected, abs=1e-12)
        found.add(com.tobytes())
        cell.override(name, mass=0.3)
        assert centre_of_mass(cell, name).tobytes() in found
        cell.remove(name)
    assert len(found) == 1


def test_the_extent_of_a_turned_can_along_the_axes_of_a_frame_is_that_of_its_rims():
    cell, T_wo = Cell(), pose((0.3, -0.1, 1.0), (0.9, 0.4, -0.2, 0.3))
    T_wf = pose((0.2, 0.1, -0.3), (0.6, -0.2, 0.7, 0.1))
    cell.add(Can(), T_wo, name="can")
    angles = np.linspace(0.0, 2.0 * np.pi, 3600)
    rim = 0.033 * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    points = np.concatenate([rim, rim + [0.0, 0.0, 0.1]]) @ T_wo.rotation.T + T_wo.translation
    points = (points - T_wf.translation) @ T_wf.rotation
    lower, upper = extent(cell, "can", T_wf)
    assert lower == pytest.approx(points.min(axis=0), abs=1e-6)
    assert upper == pytest.approx(points.max(axis=0), abs=1e-6)


def test_the_nearest_free_object_is_found_by_the_distance_of_surfaces():
    cell = Cell()
    with cell.editing():
        for name, x, free in (
            ("it", 0.0, True),
            ("a", 0.3, True),
            ("b", -0.2, True),
            ("fixed", 0.1, False),
        ):
            cell.add(Sphere(radius=0.04), pose((x, 0.0, 1.0)), name=name, free=free)
    assert nearest_free(cell, "it", 1.0) == pytest.approx(0.12)
    assert nearest_free(cell, "it", 0.1) == 0.1
    assert nearest_free(cell, "fixed", 1.0) == pytest.approx(0.02)
