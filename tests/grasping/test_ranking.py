"""Ranking of grasp candidates by cost."""

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.grasping.ranking import GraspRanking
from tests.grippers.shapes import DOWN, HAND, candidates, solid


def ranking(table, com=(0.0, 0.0, 0.0), T_now=None):
    T_now = (
        pin.SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 0.4])) if T_now is None else T_now
    )
    return GraspRanking(table, pin.SE3.Identity(), np.array(com), T_now)


def test_a_cube_is_gripped_from_above_first_at_no_cost():
    found = list(ranking(candidates(solid("box", 0.025, 0.025, 0.025))).by_cost())
    for one in found[:4]:
        assert one.T_wt.rotation[:, 2] == pytest.approx(DOWN)
        assert one.T_wt.translation == pytest.approx([0.0, 0.0, 0.015])
        assert one.cost == 0.0 and one.describe() == "from above, 50 mm wide"
    assert found[4].costs["tilt"] > 0.4 and "tilt 0.50" in found[4].describe()


def test_grasps_of_different_costs_come_in_their_order_whatever_the_rotation():
    table = candidates(solid("box", 0.025, 0.025, 0.025))
    for order in (np.arange(len(table)), np.arange(len(table))[::-1]):
        costs = {"order": np.where(order == len(table) - 1, np.inf, 2.0 * order)}
        found = ranking(replace(table, costs=costs)).by_cost()
        assert np.argsort([grasp.costs["order"] for grasp in found]).tolist() == [
            *range(len(order))
        ]


def test_of_equally_good_grasps_the_one_with_the_smallest_rotation_comes_first():
    table = candidates(solid("box", 0.025, 0.025, 0.025))
    for angle in (0.3, 1.4, -1.4, 2.8):
        T_now = pin.SE3(pin.utils.rotate("z", angle) @ np.diag([1.0, -1.0, -1.0]), np.zeros(3))
        first = next(ranking(table, T_now=T_now).by_cost())
        turned = pin.log3(T_now.rotation.T @ first.T_wt.rotation)
        assert np.linalg.norm(turned) <= math.pi / 4 + 1e-9


def test_the_nearest_grasp_of_a_ball_is_turned_to_the_tool():
    at = np.array([0.1, -0.05, 0.02])
    table = candidates(solid("sphere", 0.025, at=at))
    for angle in (0.3, 1.4, -2.8):
        T_now = pin.SE3(pin.utils.rotate("z", angle) @ np.diag([1.0, -1.0, -1.0]), at)
        first = next(ranking(table, T_now=T_now).by_distance())
        assert first.T_wt.rotation == pytest.approx(T_now.rotation, abs=1e-9)
        assert first.T_wt.translation[:2] == pytest.approx(at[:2], abs=1e-9)
        assert first.tool_distance == pytest.approx(0.0, abs=1e-6)
        assert first.grasp.T_ot.isApprox(first.T_wt)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_nearest_of_parallel_grasps_is_the_one_whose_approach_axis_is_nearest(side):
    table = candidates(solid("box", 0.1, 0.015, 0.015))
    T_now = pin.SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.04 * side, 0.0, 0.4]))
    found = list(ranking(table, com=(0.01, 0.02, 0.0), T_now=T_now).by_distance())
    assert found[0].T_wt.translation[0] == pytest.approx(0.6 * (0.1 - HAND.pad) * side)
    for one in found:  # 1 rad for each 10 cm beside the axis
        turn = np.linalg.norm(pin.log3(T_now.rotation.T @ one.T_wt.rotation))
        offset = T_now.translation - one.T_wt.translation
        beside = np.linalg.norm(np.cross(offset, one.T_wt.rotation[:, 2]))
        assert one.tool_distance == pytest.approx(turn + 10.0 * beside, abs=1e-6)
    assert (np.diff([one.tool_distance + 0.3 * one.cost for one in found]) > -1e-9).all()


def test_from_a_tool_that_points_up_the_nearest_grasp_still_has_a_pose():
    upwards = pin.SE3(np.eye(3), np.zeros(3))
    first = next(ranking(candidates(solid("sphere", 0.025)), T_now=upwards).by_distance())
    assert np.linalg.det(first.T_wt.rotation) == pytest.approx(1.0)


@pytest.mark.parametrize("x", [0.0, 0.02, 0.045, 0.2])
def test_a_centre_of_mass_beside_the_tool_costs_up_to_half_an_approach_from_the_side(x):
    found = list(
        ranking(candidates(solid("box", 0.025, 0.025, 0.025)), com=(x, 0.0, 0.0)).by_cost()
    )
    for one in found:
        beside = math.hypot(x - one.T_wt.translation[0], one.T_wt.translation[1])
        assert one.costs["balance"] == pytest.approx(0.5 * min(beside / 0.05, 1.0))


@pytest.mark.parametrize("kind", ["sphere", "box"])
def test_grasps_keep_their_order_and_costs_where_the_object_and_the_tool_are_moved(kind, rng):
    com = np.array([0.08, 0.0, 0.03])
    table = candidates(solid(kind, 0.02, 0.03, 0.025, at=(0.1, -0.05, 0.02)))
    table = replace(table, costs={"drawn": 10.0 * rng.permutation(len(table))})
    T_wo = pin.SE3(pin.utils.rotate("z", 0.7), np.array([0.3, -0.2, 0.5]))
    T_now = pin.SE3(pin.rpy.rpyToMatrix(2.9, 0.2, 0.4), np.array([0.1, 0.2, 0.4]))
    still = GraspRanking(table, pin.SE3.Identity(), com, T_now)
    moved = GraspRanking(table, T_wo, com, T_wo * T_now)
    for order in (GraspRanking.by_cost, GraspRanking.by_distance):
        for here, there in zip(order(still), order(moved), strict=True):
            assert there.T_wt.isApprox(T_wo * here.T_wt, 1e-6)
            assert there.grasp.T_ot.isApprox(here.grasp.T_ot, 1e-6)
            assert there.cost == pytest.approx(here.cost)
            assert there.tool_distance == pytest.approx(here.tool_distance, abs=1e-6)
