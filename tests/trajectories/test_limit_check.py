"""Used fractions of limits."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.robots import JointLimits, sampling_bounds
from bt_manip.trajectories import PathLimits, limit_use, tool_use
from bt_manip.trajectories.limit_check import motor_efforts, sampled_effort_use

from .pendulum import pendulum

ONE = np.ones(2)
LIMITS = JointLimits(-3 * ONE, 3 * ONE, 2 * ONE, 5 * ONE, 100 * ONE, ONE)


class Motion:
    """A motion of 0.1 s whose sample is a function of the times."""

    duration, end = 0.1, np.zeros(2)

    def __init__(self, sample):
        self.sample = lambda times: sample(times[:, np.newaxis])


def test_a_jump_of_the_position_is_outside_the_limits():
    def jump(t):
        q = np.where(t > 0.05, 1.0, 0.0) * ONE
        return q, 0 * q, 0 * q

    assert not limit_use(Motion(jump), LIMITS).inside


def test_a_jump_of_the_acceleration_at_the_very_end_counts_as_jerk():
    def stop(t):
        a = np.where(t < 0.1 - 1e-9, 1.0, 0.0) * ONE
        return 0 * a, 0 * a, a

    assert limit_use(Motion(stop), LIMITS).jerk == pytest.approx(1000 / 100)


@pytest.mark.filterwarnings("error")
def test_unlimited_joints_use_no_position_limit():
    endless = np.array([np.inf, 3.0])
    limits = JointLimits(-endless, endless, 2 * ONE, 5 * ONE, 100 * ONE, ONE)
    still = Motion(lambda t: (1.5 + 0 * t * ONE, 0 * t * ONE, 0 * t * ONE))
    assert limit_use(still, limits).position == pytest.approx(0.5)


def test_the_first_setpoint_beyond_a_limit_is_named():
    still = np.zeros((3, 2))
    s = np.linspace(0.0, 1.0, 20000)[:, np.newaxis]
    slow = s**3 * (10.0 - 15.0 * s + 6.0 * s**2) * np.array([0.0, 0.5])
    smooth = slow[::10]
    assert LIMITS.setpoints_problem(still, smooth) == ""
    assert "position of joint 2 is 3.0" in LIMITS.setpoints_problem(still, 6.5 * slow)
    assert "velocity of joint 2 in setpoint" in LIMITS.setpoints_problem(still, smooth[::5])
    assert "acceleration of joint 2 in setpoint" in LIMITS.setpoints_problem(still, smooth[::3])
    jump = LIMITS.setpoints_problem(still, smooth[1200:])
    assert jump == "velocity of joint 2 where it joins the present one"
    assert LIMITS.setpoints_problem(still, smooth * np.nan) == "a setpoint is not finite"
    assert "shape (20000, 1)" in LIMITS.setpoints_problem(still, s)


def test_a_joint_beyond_its_limit_may_stay_there_but_not_go_out_again():
    limits = JointLimits(-3 * ONE, 3 * ONE, 1e3 * ONE, 1e7 * ONE, 1e11 * ONE, ONE)
    before = np.array([3.03, 3.02, 3.01])[:, np.newaxis] * ONE
    assert limits.setpoints_problem(before, np.array([3.01, 3.0])[:, np.newaxis] * ONE) == ""
    again = limits.setpoints_problem(before, np.array([3.01, 3.02])[:, np.newaxis] * ONE)
    assert "position of joint 1 is 3.02" in again
    boxed = replace(LIMITS, box=np.zeros((2, 3)))  # of a tool that no arm places yet
    assert boxed.leaving(np.zeros((2, 2))) == ""


@pytest.mark.parametrize(
    ("kind", "distance", "seconds"),
    [  # of the quintic from rest to rest: 15/8 d/T, 10/sqrt(3) d/T^2, 60 d/T^3
        ("velocity", 2.5, 15 / 8 * 2.5 / 2.0),
        ("acceleration", 0.5, np.sqrt(10 / np.sqrt(3) * 0.5 / 5.0)),
        ("jerk", 0.05, np.cbrt(60 * 0.05 / 100.0)),
    ],
)
def test_setpoints_may_use_a_limit_up_to_its_end(kind, distance, seconds):
    power = ("velocity", "acceleration", "jerk").index(kind) + 1
    still = np.zeros((3, 2))
    for use, refused in ((0.95, False), (1.05, True)):
        s = np.linspace(0.0, 1.0, round(1e3 * seconds / use ** (1 / power)) + 1)[:, np.newaxis]
        setpoints = s**3 * (10.0 - 15.0 * s + 6.0 * s**2) * np.array([0.0, distance])
        problem = LIMITS.setpoints_problem(still, setpoints)
        assert problem.startswith(f"{kind} of joint 2") if refused else not problem


@pytest.mark.parametrize(("of_joint", "of_other"), [(1.0, 0.1), (-0.2, 0.45)])
def test_of_joints_and_other_coordinates_the_one_nearest_its_limit_counts(of_joint, of_other):
    limits = PathLimits(LIMITS, np.array([[0.5], [2.0], [50.0]]))
    v = np.tile([0.1, of_joint, of_other], (3, 1))
    velocity, acceleration, jerk = limits.use(0.0 * v, v, 0.0 * v)
    assert velocity == pytest.approx(max(abs(of_joint) / 2.0, of_other / 0.5))
    assert acceleration == jerk == 0.0


def test_every_kind_of_limit_counts_over_all_joints_and_steps(rng):
    q, v, a = rng.normal(size=(3, 6, 2)) * [[[0.3]], [[200.0]], [[1.0]]]
    lower, upper, j = np.array([-1.0, -0.2]), np.array([2.0, 0.9]), np.array([70.0, 900.0])
    limits = JointLimits(lower, upper, np.array([2.0, 7.0]), np.array([5.0, 3.0]), j, ONE)
    use, steps = limits.use(q, v, a), np.diff(q, axis=0) / 1e-3
    assert use.position == pytest.approx(np.abs((2 * q - [1.0, 0.7]) / [3.0, 1.1]).max())
    velocity = np.abs(np.vstack([v, steps]) / [2.0, 7.0])
    assert use.velocity == pytest.approx(velocity.max())
    assert use.acceleration == pytest.approx(np.abs(a / [5.0, 3.0]).max())
    assert use.jerk == pytest.approx(np.abs(np.diff(a, axis=0) / (1e-3 * j)).max())
    np.testing.assert_allclose(limits.velocity_use(q, steps[[0]]), np.abs(steps[0]) / [2.0, 7.0])
    low, high = sampling_bounds(np.array([-9.0, -9.0, -9.0, 4.0]), np.array([9.0, -4.0, 1.0, 9.0]))
    assert np.array_equal(low, [-np.pi, -9.0, -np.pi, 4.0])
    assert np.array_equal(high, [np.pi, -4.0, 1.0, 9.0])


def test_the_tool_keeps_its_speed_and_its_box():
    # The tip of the pendulum is at (cos q, 0, -sin q).
    box = np.array([[-2.0, -1.0, -0.5], [2.0, 1.0, 0.3]])
    model = pendulum(velocity=50.0, jerk=1e9, acceleration=1e6)
    limits = replace(model.limits, box=box, tool_speed=0.4, arm=model)
    for speed, problem in ((0.398, ""), (-0.402, "speed of the tool, 0.402 m/s")):
        q = speed * 1e-3 * np.arange(1, 400)[:, np.newaxis]
        assert limits.tool_use(q, 1e-3) == pytest.approx(abs(speed) / 0.4)
        assert limits.setpoints_problem(np.zeros((3, 1)), q) == problem
        references = q[0] * np.array([[0.0], [30.0], [50.0]])
        assert limits.at_scale(0.5).reference_problem(references, (0.03, 0.02)) == ""
        assert limits.reference_problem(1.06 * references, (0.03, 0.02)) == "speed of the tool"
    s = np.linspace(0.0, 1.0, 141)[:, np.newaxis]
    out = limits.leaving(0.8 * s)  # 0.46 is inside, 0.57 the next that is checked
    assert out == "z of the tool is -0.541 m, its bounds are -0.5 to 0.3 m"
    assert limits.leaving(0.525 * s, 0.002) == "" and "is 0.301 m" in limits.leaving(-0.306 * s)
    assert limits.leaving(0.56 + 0.1 * s[::-1]) == ""  # from outside towards the box


def test_efforts_are_those_of_a_pendulum_with_damping_and_dry_friction(rng):
    model = pendulum(gravity=-9.81, effort=7.0, damping=3.0)
    model.friction[:] = 1.5
    q, v, a = rng.normal(size=(3, 5, 1))
    tau = 2.0 * a - 2.0 * 9.81 * np.cos(q) + 3.0 * v + 1.5 * np.sign(v)  # turning lowers it
    np.testing.assert_allclose(motor_efforts(model, q, v, a), tau, atol=1e-9)
    assert tau.max() < -tau.min()
    assert sampled_effort_use(model, q, v, a) == pytest.approx(-tau.min() / 7.0)


def test_the_speed_of_the_tool_is_found_between_coarse_steps():
    # q' = 0.2 + 0.1 sin(70 t) rad/s, whose maxima are between two steps of 10 ms.
    model = pendulum()
    limits = replace(model.limits, tool_speed=0.3, arm=model)
    motion = Motion(lambda t: (0.2 * t - 0.1 / 70.0 * np.cos(70.0 * np.minimum(t, 0.1)),))
    for start, most in ((0.0, 0.29998), (0.03, 0.284484)):  # at first, or just after the start
        assert tool_use(motion, limits, start) == pytest.approx(most / (0.995 * 0.3), rel=1e-4)
    assert tool_use(motion, model.limits) == 0.0
