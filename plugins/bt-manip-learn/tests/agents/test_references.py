"""References move within a step of an agent, within the limits of the joints."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from bt_manip_learn.agents.references import StepReference

STEPS, DT = 50, 1e-3
VELOCITY = np.array([1.0, 2.0])  # [rad/s]


def at_rest():
    limits = SimpleNamespace(lower=np.full(2, -2.0), upper=np.full(2, 2.0), velocity=VELOCITY)
    return StepReference(np.zeros(2), SimpleNamespace(limits=limits), STEPS, DT)


def test_a_restored_state_rests_and_continues_a_parabola_through_its_targets():
    one, other, target = at_rest(), at_rest(), np.array([0.005, -0.01])
    one.move_to(target, np.zeros(2))
    one.finish()
    other.hold_at(np.full(2, 0.05))
    other.move_to(-target, np.full(2, 0.05))
    other.set_state(one.get_state())
    other.advance(DT)
    np.testing.assert_array_equal([other.q, other.v, other.a], [one.q, one.v, one.a])
    for reference in (one, other):
        reference.move_to(4 * target, target)  # q = target t^2 / T^2 at t = T and 2 T
        reference.finish()
        assert reference.q == pytest.approx(4 * target)
        assert reference.v == pytest.approx(4 * target / (STEPS * DT))


def test_a_blocked_joint_starts_at_rest_a_tenth_of_a_radian_from_where_it_is():
    reference, target = at_rest(), VELOCITY * STEPS * DT
    reference.move_to(target, np.zeros(2))
    reference.finish()
    reference.move_to(target, target - [0.0, 0.2])
    assert reference.q == pytest.approx(target - [0.0, 0.1])
    assert reference.v == pytest.approx([VELOCITY[0], 0.0])


@pytest.mark.parametrize(("uniformly", "moved"), [(True, [0.4, -2.0]), (False, [0.8, -2.0])])
def test_motions_that_are_too_fast_are_clipped_or_scaled_within_the_limits(uniformly, moved):
    reference, T = at_rest(), STEPS * DT
    reference.hold_at(np.array([0.3, -1.6]))
    reference.v[:] = [0.2, -0.4]
    target, end = np.array([0.34, -1.8]), np.array([0.3, -1.6]) + np.array(moved) * T
    reference.move_to(target, reference.q, uniformly=uniformly)
    v_end = np.clip(1.5 * (end - [0.3, -1.6]) / T, -VELOCITY, VELOCITY)
    cubic = CubicHermiteSpline([0.0, T], [[0.3, -1.6], end], [[0.2, -0.4], v_end])
    for step in range(STEPS + 1):
        t = step * DT
        assert reference.q == pytest.approx(cubic(t)) and reference.v == pytest.approx(cubic(t, 1))
        assert reference.a == pytest.approx(cubic(t, 2), abs=1e-9)
        reference.advance(DT)
    reference.hold_at(np.array([1.98, -1.99]))
    reference.move_to(np.array([3.0, -3.0]), reference.q)
    positions, velocities, _ = reference.finish()
    assert reference.q == pytest.approx([2.0, -2.0])  # the ends of the ranges
    assert positions[0] == pytest.approx([1.98, -1.99]) and not velocities[0].any()
