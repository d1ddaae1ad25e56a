"""Limits of motions: read from a model, used by samples, kept by setpoints and references."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.robots import LimitUse, MotionLimits, Robot, sampling_bounds
from tests.robot_fixtures import described
from tests.trajectories.pendulum import pendulum

ONE = np.ones(2)
LIMITS = MotionLimits(-3 * ONE, 3 * ONE, 2 * ONE, 5 * ONE, 100 * ONE, ONE)


@pytest.mark.parametrize("times", [(0.02, 0.02), (0.01, 0.05), (0.05, 0.01)])
@pytest.mark.parametrize("joint", [0, 1])
def test_references_of_a_constant_acceleration_may_exceed_a_limit_by_its_tolerance(times, joint):
    t = np.array([0.0, times[0], sum(times)])
    # Up to 5 % beyond the limits of 5 rad/s2 and 2 rad/s, and 0.001 rad/s2 and rad/s.
    for size, motion, problem in (
        (5.2509, 0.5 * t**2, ""),
        (5.2511, 0.5 * t**2, "acceleration"),
        (2.1009, t, ""),
        (2.1011, t, "velocity"),
    ):
        for signed in (size, -size):
            q = np.outer(signed * motion, np.arange(2) == joint)
            found = LIMITS.reference_problem(q, times)
            assert found.startswith(f"{problem} of joint {joint + 1}" if problem else "")
            assert bool(found) is bool(problem)


def test_a_joint_beyond_its_limit_may_stay_there_but_not_go_out_again():
    limits = MotionLimits(-3 * ONE, 3 * ONE, 1e3 * ONE, 1e7 * ONE, 1e11 * ONE, ONE)
    before = np.array([3.03, 3.02, 3.01])[:, np.newaxis] * ONE
    assert limits.setpoints_problem(before, np.array([3.01, 3.0])[:, np.newaxis] * ONE) == ""
    again = limits.setpoints_problem(before, np.array([3.01, 3.02])[:, np.newaxis] * ONE)
    assert "position of joint 1 is 3.02" in again
    assert LIMITS.setpoints_problem(before, before * np.nan) == "a setpoint is not finite"
    assert "shape (3, 1)" in LIMITS.setpoints_problem(before, before[:, :1])
    boxed = replace(LIMITS, box=np.zeros((2, 3)))  # of a tool that no arm places yet
    assert boxed.leaving(np.zeros((2, 2))) == ""


@pytest.mark.parametrize(
    ("kind", "accepted", "refused"),
    [  # beyond limits of 2, 5 and 100 by 0.01 %, 0.5 % and 0.5 %, and by 1e-6, 1e-4 and 0.1
        ("velocity", 2.000199, 2.000203),
        ("acceleration", 5.02505, 5.02515),
        ("jerk", 100.55, 100.65),
    ],
)
def test_differences_of_setpoints_may_exceed_a_limit_by_its_tolerance(kind, accepted, refused):
    kinds = ("velocity", "acceleration", "jerk")
    order, unlimited = kinds.index(kind) + 1, dict.fromkeys(kinds, 1e15 * ONE)
    signs = [[1.0] * 9, [1.0] * 4 + [-1.0] * 4, [1.0] * 3 + [-1.0] * 6 + [1.0] * 3][order - 1]
    limits = replace(LIMITS, **{**unlimited, kind: getattr(LIMITS, kind)})
    for size, refusing in ((accepted, False), (refused, True)):
        q = size * np.array(signs)
        for _ in range(order):
            q = np.cumsum(q) * 1e-3
        for rest, where in ((5, f"in setpoint {5 - order}"), (0, "where it joins the present one")):
            setpoints = np.outer(np.r_[np.zeros(rest), q], [0.0, -1.0])
            problem = limits.setpoints_problem(np.zeros((3, 2)), setpoints)
            assert problem == (f"{kind} of joint 2 {where}" if refusing else "")


def test_a_range_and_a_use_have_a_tolerance_and_the_tool_counts_with_its_arm_only():
    for q in (np.array([1.0, 3.001]), np.array([-3.001, 1.0])):
        assert not LIMITS.contain(q) and LIMITS.contain(q, 0.002)
        assert not LIMITS.contain(0.999 * q, -0.01) and LIMITS.contain(0.99 * q, -0.01)
    for i in range(4):
        uses = (LimitUse(*(1.0 + beyond * (np.arange(4) == i))) for beyond in (5e-7, 2e-6))
        assert [use.inside for use in uses] == [True, False]
    alone = replace(LIMITS, tool_speed=0.5)
    assert not alone.limits_tool and alone.at_scale(0.5) is alone


def test_every_kind_of_limit_counts_over_all_joints_and_steps(rng):
    q, v, a = rng.normal(size=(3, 6, 2)) * [[[0.3]], [[200.0]], [[1.0]]]
    lower, upper, j = np.array([-1.0, -0.2]), np.array([2.0, 0.9]), np.array([70.0, 900.0])
    limits = MotionLimits(lower, upper, np.array([2.0, 7.0]), np.array([5.0, 3.0]), j, ONE)
    use, steps = limits.use(q, v, a), np.diff(q, axis=0) / 1e-3
    assert use.position == pytest.approx(np.abs((2 * q - [1.0, 0.7]) / [3.0, 1.1]).max())
    velocity = np.abs(np.vstack([v, steps]) / [2.0, 7.0])
    assert use.velocity == pytest.approx(velocity.max())
    assert use.acceleration == pytest.approx(np.abs(a / [5.0, 3.0]).max())
    assert use.jerk == pytest.approx(np.abs(np.diff(a, axis=0) / (1e-3 * j)).max())
    slow = 1e-3 * steps[[0]]
    np.testing.assert_allclose(limits.velocity_use(q, slow), np.abs(slow[0]) / [2.0, 7.0])
    low, high = sampling_bounds(np.array([-9.0, -9.0, -9.0, 4.0]), np.array([9.0, -4.0, 1.0, 9.0]))
    assert np.array_equal(low, [-np.pi, -9.0, -np.pi, 4.0])
    assert np.array_equal(high, [np.pi, -4.0, 1.0, 9.0])


def test_the_tool_keeps_its_speed_and_its_box():
    # The tip of the pendulum is at (cos q, 0, -sin q).
    box = np.array([[-2.0, -1.0, -0.5], [2.0, 1.0, 0.3]])
    model = pendulum(velocity=50.0, jerk=1e9, acceleration=1e6)
    limits = replace(model.limits, box=box, tool_speed=0.4, arm=model)
    for speed, problem in ((0.4003, ""), (-0.4006, "speed of the tool, 0.401 m/s")):
        q = speed * 1e-3 * np.arange(1, 400)[:, np.newaxis]
        assert limits.tool_use(q, 1e-3) == pytest.approx(abs(speed) / 0.4)
        assert limits.setpoints_problem(np.zeros((3, 1)), q) == problem
        references = q[0] * np.array([[0.0], [30.0], [50.0]])
        assert limits.at_scale(0.5).reference_problem(references, (0.03, 0.02)) == ""
        assert limits.reference_problem(1.047 * references, (0.03, 0.02)) == ""
        assert limits.reference_problem(1.06 * references, (0.03, 0.02)) == "speed of the tool"
    s = np.linspace(0.0, 1.0, 141)[:, np.newaxis]
    out = limits.leaving(0.8 * s)  # 0.46 is inside, 0.57 the next that is checked
    assert out == "z of the tool is -0.541 m, its bounds are -0.5 to 0.3 m"
    assert limits.leaving(0.525 * s, 0.002) == "" and "is 0.301 m" in limits.leaving(-0.306 * s)
    slow = np.linspace(0.0, 1.0, 3000)[:, np.newaxis] ** 2 * np.linspace(3.0, 1.0, 3000)[:, None]
    for depth, problem in ((0.5009, ""), (0.5011, "z of the tool is -0.501 m")):
        found = limits.setpoints_problem(np.zeros((3, 1)), slow * np.arcsin(depth))
        assert found.startswith(problem) and bool(found) is bool(problem)
    assert limits.leaving(0.56 + 0.1 * s[::-1]) == ""  # from outside towards the box


def test_limits_come_from_the_model_and_the_description(tmp_path):
    path, link = tmp_path / "arm.xml", '<body><joint name="{}"/><geom size=".1"/>'
    path.write_text(
        f"""<mujoco><compiler angle="radian"/><worldbody>{link.format("shoulder")}
        {link.format('elbow" range="-0.4 0.7" limited="true')}<site name="tip"/></body></body>
        </worldbody><actuator><motor joint="shoulder" forcerange="-20 20" forcelimited="true"/>
        <motor joint="elbow" ctrlrange="-7 7" ctrllimited="true"/></actuator></mujoco>"""
    )
    given = {"velocity": (1.0, 2.0), "acceleration": (5.0, 6.0), "jerk": (70.0, 90.0)}
    limits = Robot(replace(described(path), **given, limit_margin=0.2, tool_speed=0.5)).limits
    assert limits.lower.tolist() == [-np.inf, -0.4] and limits.upper.tolist() == [np.inf, 0.7]
    for name, values in given.items():
        assert getattr(limits, name) == pytest.approx(0.8 * np.array(values))
    assert limits.effort.tolist() == [20.0, 7.0] and limits.tool_speed == 0.5
