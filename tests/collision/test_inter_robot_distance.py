"""The distance of two robots, and motions that are too close where any of their samples is."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.collision import InterRobotDistance, RobotGeometry, moved_bodies
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip.spatial import pose


def test_the_distance_of_two_robots_is_that_of_their_nearest_shapes_with_open_grippers(rng):
    cell, robots = Cell(), [Robot(panda(), gripper=TwoFingerGripper) for _ in range(2)]
    with cell.editing():
        for name, x, robot in zip(("left", "right"), (0.0, 0.75), robots, strict=True):
            cell.add(robot, pose((x, 0.0, 0.0), (0.75 - x, 0.0, 0.0, x)), name=name, free=False)
    measure = InterRobotDistance(*(RobotGeometry(robot, robot.make_model()) for robot in robots))
    model, data = cell.model, mujoco.MjData(cell.model)
    solid = (model.geom_contype | model.geom_conaffinity) != 0
    first, second = (
        np.flatnonzero(moved_bodies(model, robot.dof_adr)[model.geom_bodyid] & solid)
        for robot in robots
    )
    box = model.geom_type == int(mujoco.mjtGeom.mjGEOM_BOX)
    compared = 0
    for q in np.array(panda().home) + rng.normal(scale=0.3, size=(50, 2, 7)):
        for robot, configuration in zip(robots, q, strict=True):
            data.qpos[robot.qpos_adr] = configuration
            robot.gripper.set_opening(data.qpos)
        mujoco.mj_kinematics(model, data)
        pairs = [(a, b) for a in first.tolist() for b in second.tolist()]
        distances = [mujoco.mj_geomDistance(model, data, a, b, 0.07, None) for a, b in pairs]
        nearest = int(np.argmin(distances))
        if not box[list(pairs[nearest])].all():  # the contacts of boxes are nearer at corners
            assert measure.distance(*q) == pytest.approx(distances[nearest], abs=1e-4)
            compared += -0.02 < distances[nearest] < 0.07
    assert compared > 5


class Given(InterRobotDistance):
    """Robots with given distances in their configurations."""

    def __init__(self, distance):
        self.distance = distance


@pytest.mark.parametrize("n", [1, 4, 10, 11, 26, 47])
def test_of_two_motions_near_each_other_every_sample_counts(n):
    def distance(q_first, q_second):
        assert np.array_equal(q_first, -q_second)
        return distances[int(q_first[0])]

    samples, given = np.arange(float(n))[:, np.newaxis], Given(distance)
    distances = np.full(n, 0.03)
    assert not given.too_close(samples, -samples, 0.03)
    for i in range(n):
        distances[:], distances[i] = 0.03, 0.029
        assert given.too_close(samples, -samples, 0.03), i


def test_far_robots_are_measured_at_few_samples():
    measured = []
    far = Given(lambda q_first, q_second: measured.append(int(q_first[0])) or 0.07)
    assert not far.too_close(np.arange(95.0)[:, np.newaxis], np.zeros((95, 1)), 0.03)
    assert np.diff([*measured, 94]).max() <= 10 and len(measured) < 12  # 2.5 m/s at 2 ms: 50 mm
