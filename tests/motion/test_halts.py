"""Halts take about the shortest time that path and limits allow, as a reference has it."""

import numpy as np
import pytest

from benchmarks import fastest_halt
from benchmarks.halting import clock_of, halts
from bt_manip.motion import Arm, StraightPath
from bt_manip.motion.bounds import Bounds
from bt_manip.motion.clock_limits import Curve
from bt_manip.motion.halting import halting_clocks

from .test_path_timing import pendulum

TURN = np.array([1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_halts_of_every_kind_of_motion_keep_path_and_limits_and_are_about_the_fastest():
    for halt in halts(5):
        assert halt.off <= 1e-3, halt
        assert halt.used <= 1.0 + 1e-6, halt
        assert halt.ratio <= 1.1, halt


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
    slow = next(halting_clocks(curve, state, arm.model, 0.3))
    found = fastest_halt.on_the_path(curve, state, arm.model, slow)
    assert found == pytest.approx(v / a + a / j, rel=0.01)


def test_a_motor_that_is_too_weak_for_the_limits_takes_its_own_time():
    # 10 N m turn 2 kg m2 by 5 rad/s2, whatever the joint may do beside that.
    weak = pendulum(effort=10.0)
    path = StraightPath(np.zeros(1), np.ones(1))
    curve, state = Curve(path.evaluate, Bounds.of_joints(weak.limits), 1.0), (0.0, 1.0, 0.0)
    slow = next(halting_clocks(curve, state, weak, 0.8))
    assert slow.duration == pytest.approx(1.0 / 4.0, rel=0.01)
    assert fastest_halt.alone(curve, state) < 0.02
    assert fastest_halt.on_the_path(curve, state, weak, slow) == pytest.approx(0.2, rel=0.02)


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
