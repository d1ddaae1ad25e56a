"""Halts take about the shortest time that path and limits allow, as a reference has it."""

import numpy as np
import pytest

from bt_manip.arm import Arm
from bt_manip.trajectories import StraightPath, halt, plan_stop
from bt_manip.trajectories.kinematic_limits import KinematicLimits
from bt_manip.trajectories.limit_check import CONTROL_STEP, jumps, sample_times, sampled_limit_use
from bt_manip.trajectories.motion_profile import MotionProfile, profile_to_velocity
from bt_manip.trajectories.stop_search import halting_clocks
from bt_manip.trajectories.time_scaling_limits import Curve
from bt_manip.trajectories.trajectory import JointTrajectory
from tests.measuring.stops import halts

from .test_path_timing import pendulum

TURN = np.array([1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_halts_of_every_kind_of_motion_keep_path_and_limits_and_are_computed_quickly():
    for found in halts(5):
        assert found.off <= 1e-3, found
        assert found.used <= 1.0 + 1e-6, found
        assert found.computing <= 100.0, found


def test_a_joint_that_cruises_rests_after_the_time_of_the_textbook(arm):
    # v / a to brake, and a / j for the acceleration to come and to go.
    arm.move_to_configuration(arm.model.home + TURN)
    for _ in range(400):
        arm.advance(1e-3)
    limits = arm.model.limits
    v, a, j = (limit[0] for limit in (limits.velocity, limits.acceleration, limits.jerk))
    assert arm.v[0] == pytest.approx(v) and arm.a[0] == pytest.approx(0.0, abs=1e-9)
    arm.stop()
    assert arm.remaining == pytest.approx(v / a + a / j, rel=0.01)


def test_a_motor_that_is_too_weak_for_the_limits_takes_its_own_time():
    # 10 N m turn 2 kg m2 by 5 rad/s2, whatever the joint may do beside that.
    weak = pendulum(effort=10.0)
    path = StraightPath(np.zeros(1), np.ones(1))
    curve, state = (
        Curve(path.evaluate, KinematicLimits.of_joints(weak.limits), 1.0),
        (0.0, 1.0, 0.0),
    )
    clock = next(halting_clocks(curve, state, weak))
    assert clock.duration == pytest.approx(0.2, rel=0.03)


def test_a_joint_that_brakes_with_all_it_has_is_waited_for(model):
    # Joint 1 cannot brake harder than it does, so nothing slows down before it rests.
    limits, v = model.limits, 1.0
    first = profile_to_velocity((0.0, 1.5, -15.0), 0.0, (15.0, 7500.0))
    second = MotionProfile([[0.0, 0.0, v, 0.0, 0.0]], 2.0, 2.0 * v)
    others = [MotionProfile([], 2.0, q) for q in model.home[2:]]
    motion = JointTrajectory([first, second, *others])
    last = v / limits.acceleration[1] + limits.acceleration[1] / limits.jerk[1]
    halted = plan_stop(motion, 0.0, model)
    assert halted.duration == pytest.approx(first.duration + last, rel=0.03)


@pytest.mark.parametrize("state", [(6.4e-5, 0.048, 24.0), (1.5e-4, 0.08, 30.0), (1e-3, 1.0, 0.0)])
def test_a_clock_that_has_hardly_begun_is_not_rushed_on_to_rest(arm, state):
    arm.move_to_configuration(arm.model.home + TURN)
    whole = arm.trajectory
    halted = halt(whole, state, arm.model, (whole.duration - state[0]) / state[1])
    if halted is not None:
        rows = halted.sample(sample_times(halted.duration, CONTROL_STEP))
        assert not jumps(rows, arm.model.limits.jerk)
        assert sampled_limit_use(rows, arm.model.limits).inside


@pytest.mark.parametrize("share", [0.1, 0.4, 0.6, 0.9])
def test_the_end_of_a_halt_is_reached_in_one_go(robot, ik, share):
    arm = Arm(robot, ik=ik)
    arm.move_to_configuration(arm.model.home + TURN)
    for _ in range(int(share * arm.remaining / 1e-3)):
        arm.advance(1e-3)
    direction = np.sign(arm.v[0])
    arm.stop()
    while arm.moving:
        before = arm.q_ref
        arm.advance(1e-3)
        assert (arm.q - before)[0] * direction >= -1e-12  # never back
    assert not arm.v.any() and not arm.a.any()
