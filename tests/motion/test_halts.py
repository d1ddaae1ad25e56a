"""Halts take about the shortest time that path and limits allow, as a reference has it."""

import numpy as np
import pytest

from benchmarks import fastest_halt, jerk_limited_halt
from benchmarks.halting import clock_of, halts
from bt_manip.motion import Arm, StraightPath
from bt_manip.motion.bounds import Bounds
from bt_manip.motion.braking import brake, halt
from bt_manip.motion.braking.clock_limits import Curve
from bt_manip.motion.braking.halting import halting_clocks, shortest_rest
from bt_manip.motion.braking.programme import programmed_halt
from bt_manip.motion.jerk_profile import JerkProfile, brake_profile, joint_profiles
from bt_manip.motion.limit_check import STEP, jumps, rows_use, step_times
from bt_manip.motion.trajectory import JointTrajectory

from .test_path_timing import pendulum

TURN = np.array([1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_halts_of_every_kind_of_motion_keep_path_and_limits_and_are_about_the_fastest():
    for found in halts(5):
        assert found.off <= 1e-3, found
        assert found.used <= 1.0 + 1e-6, found
        assert found.ratio <= 1.1, found


def test_a_joint_that_cruises_rests_after_the_time_of_the_textbook(arm):
    # v / a to brake, and a / j for the acceleration to come and to go.
    arm.move_to_configuration(arm.model.home + TURN)
    for _ in range(400):
        arm.advance(1e-3)
    limits = arm.model.limits
    v, a, j = (limit[0] for limit in (limits.velocity, limits.acceleration, limits.jerk))
    assert arm.v[0] == pytest.approx(v) and arm.a[0] == pytest.approx(0.0, abs=1e-9)
    curve, state = clock_of(arm)
    assert fastest_halt.alone(curve, state) == pytest.approx(v / a + a / j, rel=1e-6)
    assert fastest_halt.along(curve, state, arm.model) == pytest.approx(v / a, rel=0.01)
    gently = -np.sin(np.linspace(0.0, np.pi, 100))
    found = jerk_limited_halt.found(curve, state, arm.model, v / a, gently, 2.5e-3)
    assert found == pytest.approx(v / a + a / j, rel=0.01)
    arm.stop()
    assert arm.remaining == pytest.approx(v / a + a / j, rel=0.01)


def test_a_motor_that_is_too_weak_for_the_limits_takes_its_own_time():
    # 10 N m turn 2 kg m2 by 5 rad/s2, whatever the joint may do beside that.
    weak = pendulum(effort=10.0)
    path = StraightPath(np.zeros(1), np.ones(1))
    curve, state = Curve(path.evaluate, Bounds.of_joints(weak.limits), 1.0), (0.0, 1.0, 0.0)
    assert fastest_halt.alone(curve, state) < 0.02
    assert fastest_halt.along(curve, state, weak) == pytest.approx(0.2, rel=0.01)
    clock = next(halting_clocks(curve, state, weak))
    assert clock.duration == pytest.approx(0.2, rel=0.03)


def test_a_joint_that_brakes_with_all_it_has_is_waited_for(model):
    # Joint 1 cannot brake harder than it does, so nothing slows down before it rests.
    limits, v = model.limits, 1.0
    first = brake_profile((0.0, 1.5, -15.0), (2.175, 15.0, 7500.0))
    second = JerkProfile([[0.0, 0.0, v, 0.0, 0.0]], 2.0, 2.0 * v)
    others = [JerkProfile([], 2.0, q) for q in model.home[2:]]
    motion = JointTrajectory([first, second, *others])
    last = v / limits.acceleration[1] + limits.acceleration[1] / limits.jerk[1]
    halted = brake(motion, 0.0, model)
    assert halted.duration == pytest.approx(first.duration + last, rel=0.03)
    curve = Curve(motion.table, Bounds.of_joints(limits), motion.duration)
    least = fastest_halt.along(curve, (0.0, 1.0, 0.0), model)
    assert 0.95 * halted.duration < least < halted.duration


def test_joints_that_get_in_each_others_way_rest_long_before_the_motion_would_end(model):
    # Each drives with all the jerk it has, at times of its own: braking as hard as each moment
    # allows leads nowhere.
    bounds = Bounds(*(np.full(7, most) for most in (3.14, 20.0, 500.0)))
    rng = np.random.default_rng(2)
    start = np.zeros(7), rng.uniform(-3.0, 3.0, 7), np.zeros(7)
    motion = JointTrajectory(joint_profiles(start, rng.uniform(-1.0, 1.0, 7), *bounds))
    now = rng.uniform(0.1, 0.5) * motion.duration
    curve = Curve(motion.table, bounds, motion.duration, motion.corners())
    state, left = (now, 1.0, 0.0), motion.duration - now
    _, v, a = motion.table(np.array([now]))
    least = shortest_rest(v[0], a[0], bounds)

    def used(clock):
        _, v, a = curve.driven(clock, step_times(clock.duration, STEP))
        assert not v[-1].any() and not a[-1].any()
        return max(bounds.use(v, a, STEP))

    assert all(used(clock) > 1.0 + 1e-3 for clock in halting_clocks(curve, state))
    found = programmed_halt(curve, state, least, left, model, allowed=100.0)
    assert used(found) <= 1.0 + 1e-6
    assert least <= found.duration < 0.75 * left


@pytest.mark.parametrize("state", [(6.4e-5, 0.048, 24.0), (1.5e-4, 0.08, 30.0), (1e-3, 1.0, 0.0)])
def test_a_clock_that_has_hardly_begun_is_not_rushed_on_to_rest(arm, state):
    arm.move_to_configuration(arm.model.home + TURN)
    whole = arm.trajectory
    halted = halt(whole, state, arm.model, (whole.duration - state[0]) / state[1])
    if halted is not None:
        rows = halted.table(step_times(halted.duration, STEP))
        assert not jumps(rows, arm.model.limits.jerk)
        assert rows_use(rows, arm.model.limits).inside


def test_a_programme_finds_the_halt_of_the_textbook(model):
    line = StraightPath(np.zeros(7), np.ones(7))
    bounds = Bounds(*(np.full(7, most) for most in (2.0, 10.0, 200.0)))
    state, textbook = (0.0, 1.0, 0.0), 1.0 / 10.0 + 10.0 / 200.0
    curve = Curve(line.evaluate, bounds, 1.0)
    found = programmed_halt(curve, state, textbook, 2.0, model, allowed=100.0)
    assert found.duration == pytest.approx(textbook, rel=0.01)


def test_what_every_joint_needs_to_rest_is_what_ruckig_finds(model, rng):
    bounds, m = Bounds.of_joints(model.limits), model.nq
    for _ in range(200):
        v, a = (rng.uniform(-1.0, 1.0, m) * most for most in (bounds.velocity, bounds.acceleration))
        line = Curve(lambda s, v=v, a=a: (v[None], v[None], a[None]), bounds, 1.0)
        assert shortest_rest(v, a, bounds) == pytest.approx(
            fastest_halt.alone(line, (0.0, 1.0, 0.0)), rel=1e-6
        )


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
