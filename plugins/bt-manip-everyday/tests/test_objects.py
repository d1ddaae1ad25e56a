"""Everyday objects have the shapes that they say, and are gripped where they are made for it."""

import mujoco
import numpy as np
import pytest

from bt_manip.behaviours import Grasp, Hover, Lift, Reach
from bt_manip.bt import Sequence
from bt_manip.cell import CellError
from bt_manip.spatial import pose
from bt_manip_everyday import Bowl, CoffeeMug

from .conftest import SURFACE


@pytest.fixture
def met():
    """Return a function that gives the distance from a point to an object along a direction."""

    def make(entity):
        root = entity.mjcf_model
        model = mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)

        def distance(point, along):
            geom, along = np.zeros(1, np.int32), np.array(along, float)
            return mujoco.mj_ray(model, data, np.array(point, float), along, None, 1, -1, geom)

        distance.friction = set(model.geom_friction[:, 0])
        return distance

    return make


def check_grasp(met, grasp, depth):
    """Check that fingers close on a wall as wide as declared, and how far the tool is over it."""
    T = grasp.T_og
    for side in (1.0, -1.0):
        begin = T.translation + 0.02 * side * T.rotation[:, 1]
        gap = met(begin, -side * T.rotation[:, 1])
        assert gap == pytest.approx(0.02 - 0.5 * grasp.width, abs=2e-4)
    begin = T.translation - 0.04 * T.rotation[:, 2]
    assert met(begin, T.rotation[:, 2]) == pytest.approx(0.04 - depth, abs=1e-3)


def test_a_mug_is_gripped_at_the_bar_of_its_handle_steeply_at_the_top_and_flatter(met):
    radius, height, handle, grip = 0.038, 0.095, 0.036, 0.009
    ray, out = met(mug := CoffeeMug()), radius + handle
    assert ray((0.2, 0, height / 2), (-1, 0, 0)) == pytest.approx(0.2 - out)
    middle, wall = radius + handle / 2, 0.004
    assert ray((middle, 0, height / 2), (1, 0, 0)) == pytest.approx(handle / 2 - grip)
    assert ray((middle, 0, height / 2), (-1, 0, 0)) == pytest.approx(handle / 2, abs=1e-3)
    for sign, z in ((-1.0, 0.8 * height), (1.0, 0.2 * height)):  # the arms of the handle
        for x in (radius + 1e-3, middle, out - 1e-3):
            assert ray((x, 0, z - 0.1 * sign), (0, 0, sign)) == pytest.approx(0.1 - grip / 2)
        assert ray((middle, 0.1, z), (0, -1, 0)) == pytest.approx(0.1 - grip / 2)
        assert ray((0, 0, z), (1, 0, 0)) == pytest.approx(radius - wall, abs=1e-3)
    for angle, part, grasp in zip((60, 45, 30), (0.68, 0.5, 0.5), mug.grasps, strict=True):
        T, a = grasp.T_og, np.radians(angle)
        assert T.translation == pytest.approx((out - grip / 2, 0.0, part * height))
        across = [-np.sin(a), 0, np.cos(a)], [0, 1, 0]
        np.testing.assert_allclose(T.rotation.T, [*across, [-np.cos(a), 0, -np.sin(a)]], atol=1e-9)
        check_grasp(ray, grasp, grip / 2 / np.cos(a))
    assert ray((0, 0, 0.2), (0, 0, -1)) == pytest.approx(0.2 - wall)
    assert ray((0, 0, -0.1), (0, 0, 1)) == pytest.approx(0.1)
    for angle in np.arange(0.05, 2 * np.pi, 0.1):
        along = np.array([np.cos(angle), np.sin(angle), 0.0])
        assert 0.0 <= ray((0, 0, 0.9 * height), along) - (radius - wall) < 1.5e-3
    edge = np.array([0.0, radius - wall / 2, 0.2])
    assert ray(edge, (0, 0, -1)) == pytest.approx(0.2 - height)


def test_a_bowl_has_no_gaps_and_is_gripped_12_mm_below_its_rim_across_its_wall(met):
    radius, height, wall, foot = 0.07, 0.055, 0.004, 0.042
    ray, slope = met(bowl := Bowl()), np.arctan2(radius - foot, height)
    assert bowl.centre_offset == pytest.approx((0.0, 0.0, height))
    assert ray((0, 0, 0.2), (0, 0, -1)) == pytest.approx(0.2 - wall)
    assert ray((0, 0, -0.1), (0, 0, 1)) == pytest.approx(0.1)
    for z in np.linspace(0.2, 0.9, 5) * height:
        for angle in np.arange(0.05, 2 * np.pi, 0.1):
            side = np.array([np.cos(angle), np.sin(angle), 0.0])
            inner = ray((0, 0, z), side)
            outer = 0.2 - ray(0.2 * side + (0, 0, z), -side)
            assert -3e-4 < (outer - inner) * np.cos(slope) - wall < 2e-3  # more at a corner
            expected = foot + (radius - foot) * z / height - wall / np.cos(slope)
            assert expected - 1e-3 < inner < 1.02 * (expected + 1e-3)  # of 16 sides
    top = ray((radius - wall / 2, 0, 0.2), (0, 0, -1))  # the edge is square to the wall
    assert top == pytest.approx(0.2 - height + wall / 2 * np.sin(slope), abs=5e-4)
    assert bowl.mass == pytest.approx(0.2)
    assert ray.friction == {0.7}
    assert len(bowl.grasps) == 8
    for i, grasp in enumerate(bowl.grasps):
        T, angle = grasp.T_og, i * np.pi / 4
        side = np.array([np.cos(angle), np.sin(angle), 0.0])
        into = -np.sin(slope) * side - np.cos(slope) * np.array([0, 0, 1])
        assert T.rotation[:, 2] == pytest.approx(into)
        assert abs(T.rotation[:, 1] @ side) == pytest.approx(np.cos(slope))
        assert np.linalg.det(T.rotation) == pytest.approx(1.0) and grasp.width == wall
        np.testing.assert_allclose(T.rotation @ T.rotation.T, np.eye(3), atol=1e-9)
        check_grasp(ray, grasp, 0.012)


@pytest.mark.parametrize(("make", "held_at"), [(CoffeeMug, 0.0695), (Bowl, 0.061)])
def test_it_is_held_by_its_handle_or_by_its_rim(station, trial, make, held_at):
    yaw = 2.5
    T_wo = pose((0.35, 0.1, SURFACE), (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)))
    name = station.cell.add(make(), T_wo)
    steps = [Hover(object=name, height=0.1), Reach(object=name), Grasp(object=name)]
    trial(Sequence(*steps, Lift(height=0.1))).tick_until("SUCCESS", timeout=10.0)
    station.cell.step(300)
    T_wo = station.cell.pose(name)
    assert T_wo.translation[2] > SURFACE + 0.07
    assert station.gripper.width < 0.012
    x, y, _ = T_wo.actInv(station.robot.tool_pose.translation)
    assert np.hypot(x, y) == pytest.approx(held_at, abs=3e-3)


def test_a_handle_without_room_for_a_finger_is_refused():
    with pytest.raises(CellError, match="handle must be a number of at least 0.03 .m., got"):
        CoffeeMug(handle=0.01)
