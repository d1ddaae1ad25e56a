"""Velocity limits that shrink towards the position limits, as a description gives them."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.robots import Robot, RobotError, panda

OFFSET, DECELERATION = 0.3, 4.0
NEAR = replace(panda(), near_offset=(OFFSET,) * 7, near_deceleration=(DECELERATION,) * 7)


def formula(distance: np.ndarray) -> np.ndarray:
    return -OFFSET + np.sqrt(2.0 * DECELERATION * distance)


@pytest.fixture(scope="module")
def both():
    """Give the limits of the Panda without and with these velocity limits."""
    return Robot(panda()).limits, Robot(NEAR).limits


def test_the_limit_is_that_of_the_formula_in_the_direction_of_motion(both):
    plain, limits = both
    q = np.linspace(limits.lower, limits.upper, 50)
    up, down = limits.velocity_at(q, np.ones_like(q)), limits.velocity_at(q, -np.ones_like(q))
    expected = np.minimum(plain.velocity, formula(plain.upper - q))
    assert (up <= expected).all() and (up >= expected - 0.01).all()
    # The limit is the one at the position that the velocity leads to within a control step.
    least, after = (
        0.025 * plain.velocity,
        (plain.upper - q - 1e-3 * up, q - 1e-3 * down - plain.lower),
    )
    for found, distance in zip((up, down), after, strict=True):
        np.testing.assert_allclose(found, np.clip(formula(distance), least, plain.velocity))
    beyond = limits.velocity_at(limits.upper + 0.5, np.ones(7))
    np.testing.assert_array_equal(beyond, least)


def test_positions_one_after_the_other_keep_the_limit_where_they_are(both):
    # 1 rad/s is the limit (1.0 + 0.3)^2 / (2 * 4) = 0.21125 rad before the position limit.
    plain, limits = both
    limits = replace(limits, acceleration=np.full(7, 1e15), jerk=np.full(7, 1e15))
    before = np.tile(0.5 * (plain.lower + plain.upper), (3, 1))
    for joint, steps, problem in ((0, 88, ""), (0, 89, "1 in setpoint 87"), (4, 88, "")):
        before[:, joint] = plain.upper[joint] - 0.3
        moved = 1e-3 * np.outer(np.arange(1, steps + 1), np.arange(7) == joint)
        found = limits.setpoints_problem(before, before[:1] + moved)
        assert found == (problem and f"velocity of joint {problem}")
    still = np.zeros_like(moved)
    used = limits.use(before[:1] + moved, still, still).velocity
    assert used == pytest.approx(1.0 / formula(0.3 - 0.088), rel=1e-5)


@pytest.mark.parametrize("ends", [{}, {"near_lower": (-1.9,) * 7, "near_upper": (1.4,) * 7}])
def test_positions_end_where_the_velocity_limit_would_be_nearly_zero(both, ends):
    plain, _ = both
    limits = Robot(replace(NEAR, home=(0.1, 0.0, 0.0, -1.5, 0.0, 1.0, 0.0), **ends)).limits
    low, high = ends.get("near_lower", plain.lower), ends.get("near_upper", plain.upper)
    step = 1e-3 * 0.025 * plain.velocity  # of the least velocity, in a control step
    apart = (OFFSET + 0.025 * plain.velocity) ** 2 / (2.0 * DECELERATION) + step
    np.testing.assert_allclose(limits.upper, np.minimum(plain.upper, high - apart), rtol=1e-12)
    np.testing.assert_allclose(limits.lower, np.maximum(plain.lower, low + apart), rtol=1e-12)
    assert plain.near is None
    assert plain.velocity_at(plain.upper, np.ones(7)) is plain.velocity


def test_the_margin_reduces_velocity_acceleration_and_jerk(both):
    plain, without = both
    limits = Robot(replace(NEAR, limit_margin=0.1)).limits
    for name in ("velocity", "acceleration", "jerk"):
        np.testing.assert_allclose(getattr(limits, name), 0.9 * getattr(plain, name))
    middle = 0.5 * (plain.lower + plain.upper)
    q, still = plain.upper - 0.05 * (plain.upper - middle), np.ones(7)
    np.testing.assert_allclose(
        limits.velocity_at(q, still), 0.9 * without.velocity_at(q, still), rtol=0.01
    )
    np.testing.assert_array_equal(limits.effort, plain.effort)


def test_limits_that_leave_a_joint_no_range_are_refused():
    offset = (5.0, *(OFFSET,) * 6)
    with pytest.raises(RobotError, match="leaves joint 'joint1' no range"):
        Robot(replace(NEAR, near_offset=offset))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"near_deceleration": None}, "[velocity_near_limits] needs 'offset' and 'deceleration'"),
        ({"limit_margin": 1.0}, "'limit_margin' is below 1, got 1"),
        ({"near_offset": (-0.1,) * 7}, "offset"),
    ],
)
def test_incomplete_or_impossible_ones_are_refused(changed, message):
    with pytest.raises(RobotError) as caught:
        replace(NEAR, **changed)
    assert message in str(caught.value) and "panda" in str(caught.value)
