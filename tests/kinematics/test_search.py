"""Searches: collisions, clearance, restarts, and following."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.kinematics import IKProblem, PoseTarget, PositionTarget, RotationTarget, search
from bt_manip.kinematics.inverse_kinematics import RESTARTS
from tests.measuring.kinematics import error_in_mujoco

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)


def wall_distance(walled, q):
    """Give the distance of the arm from the wall, by MuJoCo's own search for nearest points."""
    model, data = walled.robot.mj_model, mujoco.MjData(walled.robot.mj_model)
    data.qpos[:] = walled.robot.mj_data.qpos
    data.qpos[np.array(walled.robot.qpos_adr)] = q
    mujoco.mj_kinematics(model, data)
    wall = next(i for i in range(model.ngeom) if "wall" in model.geom(i).name)
    arm = [
        i
        for i in range(model.ngeom)
        if model.geom(i).contype and model.body(model.geom_bodyid[i]).name.startswith("panda")
    ]
    return min(mujoco.mj_geomDistance(model, data, i, wall, 1.0, None) for i in arm)


def test_a_problem_is_followed_in_small_steps_that_drift_to_its_posture(walled, robot):
    ik, world = walled.ik, walled.world
    q = ik.solve(walled.left, ik.model.home).q
    posture = q + np.array([0.4, 0.0, -0.3, 0.0, 0.0, 0.0, 0.0])
    began = ik.distance(q, posture)
    for i in range(1, 21):
        T = pin.SE3(walled.left.rotation, walled.left.translation + [0.0, 0.004 * i, 0.0])
        problem = IKProblem(
            targets=PoseTarget("panda/tool", T),
            joints=[f"joint{j}" for j in range(1, 8)],
            margin=0.05,
            posture=posture,
            world=world,
            clearance=0.008,
        )
        found = ik.follow(problem, q)
        assert found.solved and found.reason == "" and found.restarts == 0
        assert np.abs(found.q - q).max() <= 0.2 + 1e-12
        assert max(error_in_mujoco(robot, found.q, T)) <= 2e-6
        assert found.residuals[0].met
        q = found.q
    assert ik.distance(q, posture) < began


@pytest.mark.parametrize(
    "target",
    [
        PoseTarget("tool", spatial.pointing_down([0.3, 0.5, 0.3], 2.0)),
        RotationTarget("tool", spatial.pointing_down([0.0, 0.0, 0.0], 2.5).rotation),
    ],
)
def test_a_problem_is_not_followed_to_a_target_far_away(model, ik, target):
    problem = IKProblem(targets=target)
    assert ik.solve(problem, model.home).solved
    found = ik.follow(problem, model.home)
    assert not found.solved and not found.residuals[0].met
    assert found.reason == "a joint would have to jump by more than 0.2 rad"
    assert np.abs(found.q - model.home).max() <= 0.2 + 1e-12
    wide = ik.follow(problem, model.home, max_step=3.0)
    assert wide.solved


def test_solutions_are_collision_free_and_keep_a_clearance_where_they_would_collide_otherwise(
    walled,
):
    # Behind the wall: from home the elbow or the hand would go through it.
    ik, rng, touching, nearer = walled.ik, np.random.default_rng(4), 0, 0
    for _ in range(8):
        target = PositionTarget("panda/tool", rng.uniform([0.3, -0.12, 0.1], [0.6, -0.05, 0.35]))
        plain, free, wide = (
            ik.solve(IKProblem(targets=target, **given), ik.model.home)
            for given in ({}, {"world": walled.world}, {"world": walled.world, "clearance": 0.008})
        )
        touching += bool(walled.world.collisions(plain.q))
        assert free.solved and not walled.world.collisions(free.q)
        if wide.solved:
            assert wall_distance(walled, wide.q) >= 0.008 - 1e-6
            nearer += wall_distance(walled, free.q) < 0.008
    assert touching > 2 and nearer > 0


def test_where_no_solution_is_collision_free_the_reason_names_the_obstacle(walled):
    inside = spatial.pointing_down((0.5, 0.0, 0.2))
    problem = IKProblem(targets=PoseTarget("panda/tool", inside), world=walled.world)
    found = walled.ik.solve(problem, walled.ik.model.home)
    assert not found.solved
    assert "no collision-free solution from 81 initial guesses: 'panda/" in found.reason
    assert "would touch 'wall'" in found.reason


def test_following_into_an_obstacle_names_it(walled):
    q = walled.ik.solve(walled.left, walled.ik.model.home).q
    reason = ""
    for y in np.arange(0.25, 0.0, -0.02):
        T = pin.SE3(walled.left.rotation, np.array([0.5, y, 0.12]))
        found = walled.ik.follow(
            IKProblem(targets=PoseTarget("panda/tool", T), world=walled.world), q
        )
        if not found.solved:
            reason = found.reason
            break
        q = found.q
    assert "'panda/" in reason and "would touch 'wall'" in reason


def test_a_pose_that_the_limits_forbid_ends_after_so_many_restarts_or_failed_iterations(
    model, ik, monkeypatch
):
    inside_the_base = spatial.pointing_down([0.0, 0.0, 0.05])
    found = ik.solve(inside_the_base, model.home, restarts=5)
    assert not found.solved and found.restarts == 5
    assert found.reason == "no solution from 6 initial guesses"
    assert model.limits.contain(found.q)
    monkeypatch.setattr(search, "MAX_FAILED_ITERATIONS", 100)
    found = ik.solve(inside_the_base, model.home)
    assert not found.solved and found.restarts < RESTARTS
    assert 100 <= found.iterations < 100 + search.ITERATIONS


def test_following_names_the_joint_at_its_limit_or_that_it_is_out_of_reach(model, ik):
    for limit, turn in ((model.limits.upper, 0.1), (model.limits.lower, -0.1)):
        q = np.append(model.home[:6], limit[6])
        turned = model.pose(q) * pin.SE3(pin.exp3(np.array([0.0, 0.0, turn])), np.zeros(3))
        found = ik.follow(turned, q, max_step=0.05)
        assert not found.solved and "joint7 at the limit" in found.reason
    above = IKProblem(targets=PositionTarget("tool", [0.0, 0.0, 2.0]))
    found = ik.follow(above, model.home, max_step=3.0)
    assert not found.solved and found.reason == "out of reach, or singular"


def test_the_iterations_of_a_search_are_those_of_all_its_descents_and_refinements(
    walled, monkeypatch
):
    counted = []

    def counting(search_from):
        def count(*given, **options):
            counted.append(search_from(*given, **options))
            return counted[-1]

        return count

    for name in ("levenberg_marquardt", "refine"):
        monkeypatch.setattr(search, name, counting(getattr(search, name)))
    ik = walled.ik
    costs = PositionTarget("panda/tool", [0.4, 0.3, 0.5], weight=1.0)
    result = ik.solve(IKProblem(targets=costs), ik.model.home)
    assert result.solved and len(counted) > 2
    assert result.iterations == sum(end.iterations for end in counted) > 0
    counted.clear()
    away = PositionTarget("panda/tool", [2.0, 0.0, 0.5])
    result = ik.follow(IKProblem(targets=away), ik.model.home)
    assert not result.solved
    assert result.iterations == sum(end.iterations for end in counted) > 0
