"""The search for stops on a path."""

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyder, polyval

from bt_manip.robots import MotionLimits
from bt_manip.trajectories import PathLimits, StraightPath
from bt_manip.trajectories.deceleration_limits import DecelerationLimits, LimitedPath
from bt_manip.trajectories.motion_profile import profile_to_velocity
from bt_manip.trajectories.stop_search import shortest_stop_time, stop_profiles

from .pendulum import pendulum

MOVING = (0.0, 1.0, 0.0)  # s, s_dot, s_ddot


def polynomials(c):
    return lambda s: [polyval(s, polyder(c, k)).T for k in range(3)]


def straight(model):
    path = StraightPath(np.zeros(1), np.ones(1))
    return LimitedPath(path.evaluate, PathLimits(model.limits, path.limits), 1.0)


def at_control_steps(path, profile):
    return profile.sample_along(path.evaluate, np.arange(0.0, profile.duration, 1e-3))


def test_no_coordinate_stops_faster_than_ruckig_stops_it():
    rng, one = np.random.default_rng(4), np.ones(2)
    for _ in range(50):
        bound, jerk = rng.uniform(1.0, 20.0, 2), rng.uniform(50.0, 5000.0, 2)
        v = rng.uniform(-2.0, 2.0, 2) * 10.0 ** rng.uniform(-3.0, 0.0, 2)
        a = rng.uniform(-bound, bound)
        limits = MotionLimits(-one, one, 9 * one, bound, jerk, one)
        shortest = shortest_stop_time(v, a, PathLimits(limits, np.empty((3, 0))))
        alone = [
            profile_to_velocity((0.0, v[i], a[i]), 0.0, (bound[i], jerk[i])).duration
            for i in range(2)
        ]
        assert shortest == pytest.approx(max(alone), rel=1e-6, abs=1e-9)


def test_the_profiles_of_a_search_use_less_and_less_of_the_limits():
    model = pendulum(acceleration=5.0, jerk=500.0)
    margins = [0.995, 0.995, 0.995, 0.995, 0.96, 0.96, 0.9]
    for profile, margin in zip(stop_profiles(straight(model), MOVING), margins, strict=True):
        s, s_dot, s_ddot = profile.sample(np.linspace(0.0, profile.duration - 1e-6, 200))
        assert np.all(np.diff(s) >= 0.0) and s[-1] <= 1.0 and s_dot.min() >= -1e-9
        assert s_ddot.min() == pytest.approx(-5.0 * margin)
        jerks = np.array(profile.segments)[:, 4] / 500.0
        assert jerks[0] == pytest.approx(-margin)
        assert jerks[-1] == pytest.approx(0.97 * margin, rel=5e-3)


@pytest.mark.parametrize(("speed", "steps"), [(0.005, 10), (0.05, 100), (1.0, 200), (9.0, 250)])
def test_a_stop_has_enough_steps_for_its_shape_but_a_bounded_number(speed, steps):
    model = pendulum(acceleration=5.0, jerk=5e4, velocity=10.0)
    path = StraightPath(np.zeros(1), 20.0 * np.ones(1))
    limited = LimitedPath(path.evaluate, PathLimits(model.limits, path.limits), 1.0)
    profile = next(stop_profiles(limited, (0.0, speed / 20.0, 0.0)))
    assert steps <= len(profile.segments) <= steps + 5
    exact = speed / 5.0 + 1e-4  # v / a + a / j
    assert profile.duration == pytest.approx(exact, rel=0.015)


def test_where_the_path_ends_before_a_stop_there_is_none():
    model = pendulum(acceleration=5.0)  # a stop takes 0.1 rad
    assert not list(stop_profiles(straight(model), (0.95, 1.0, 0.0)))
    soft = pendulum(acceleration=5.0, jerk=50.0)  # the jerk takes 0.05 rad more
    assert not list(stop_profiles(straight(soft), (0.87, 1.0, 0.0)))


@pytest.mark.parametrize(
    ("bend", "jerk", "start"),
    [
        (0.0, 500.0, MOVING),
        (0.3, 50.0, MOVING),
        (-0.3, 500.0, MOVING),
        (0.1, 25.0, (0.0, 1.0, 3.0)),
        (0.2, 90.0, (0.1, 1.0, -4.0)),
        (0.2, 500.0, (0.0, 0.0, 3.0)),
    ],
)
def test_a_joint_stops_as_fast_as_ruckig_however_its_path_is_parameterized(bend, jerk, start):
    # q = s + b s^2: where the path parameter's own jerk is zero, the joint's is not.
    model = pendulum(acceleration=5.0, effort=1e4, jerk=jerk)

    def evaluate(s):
        s = s[:, np.newaxis]
        return s + bend * s * s, 1.0 + 2.0 * bend * s, 2.0 * bend * np.ones_like(s)

    path = LimitedPath(evaluate, PathLimits(model.limits, np.empty((3, 0))), 1.0)
    keeping = [
        (profile.duration, q, v, a)
        for profile in stop_profiles(path, start)
        for q, v, a in [at_control_steps(path, profile)]
        if np.abs(a).max() <= 5.0 and np.abs(np.diff(a[:, 0])).max() <= 1e-3 * jerk
    ]
    duration, q, v, _ = keeping[0]
    slope = 1.0 + 2.0 * bend * start[0]
    first = (0.0, slope * start[1], 2.0 * bend * start[1] ** 2 + slope * start[2])
    fastest = profile_to_velocity(first, 0.0, (5.0, jerk)).duration
    assert fastest <= duration * (1.0 + 1e-3) and duration <= 1.05 * fastest
    assert np.gradient(q[:, 0], 1e-3)[1:-1] == pytest.approx(v[1:-1, 0], abs=1e-4)


def test_where_no_path_jerk_suits_both_joints_a_stop_inside_all_limits_is_found():
    # The second joint bends while the first, whose jerk is scarce, turns evenly: braking changes
    # the second's acceleration faster than its own limit allows, unless the path jerk counters it.
    one = np.ones(2)
    limits = MotionLimits(-9 * one, 9 * one, 9 * one, 5 * one, np.array([8.0, 20.0]), one)

    def evaluate(s):
        s, even = s[:, np.newaxis], np.ones((len(s), 1))
        first, second = (s, even, 0.0 * even), (s + 2.0 * s * s, 1.0 + 4.0 * s, 4.0 * even)
        return [np.hstack(columns) for columns in zip(first, second, strict=True)]

    path = LimitedPath(evaluate, PathLimits(limits, np.empty((3, 0))), 1.0)
    fastest = shortest_stop_time(one, np.array([0.0, 4.0]), path.limits)
    inside = [
        profile.duration
        for profile in stop_profiles(path, MOVING)
        if max(path.limits.use(*at_control_steps(path, profile))) <= 1
    ]
    assert fastest <= inside[0] <= 1.11 * fastest


@pytest.mark.parametrize("seed", [5, 9, 18, 21, 37, 54])
def test_a_search_converges_in_four_profiles_to_a_stop_that_uses_a_limit_at_all_times(seed):
    # Three joints on random polynomials, moving and accelerating inside their limits.
    rng, one = np.random.default_rng(seed), np.ones(3)
    c, now = rng.normal(size=(5, 3)), 2.0
    bound = 2.0 * np.abs(c[2]) + rng.uniform(4.0, 8.0, 3) * np.abs(c[1]).max()
    jerk = bound * rng.uniform(30.0, 80.0, 3)
    joints = MotionLimits(-99 * one, 99 * one, 99 * one, bound, jerk, one)
    path = LimitedPath(polynomials(c), PathLimits(joints, np.empty((3, 0))), 1.0)
    profiles = list(stop_profiles(path, (0.0, 1.0, now)))
    uses = []
    for profile in (profiles[0], profiles[3]):
        _, _, a = at_control_steps(path, profile)
        jerks = np.abs(np.diff(a, axis=0)) / (1e-3 * jerk)
        uses.append(np.maximum(np.abs(a[1:]) / bound, jerks).max(axis=1))
    assert uses[0].max() < 1.2 and (uses[0] > 0.95).mean() > 0.7
    assert 0.99 < uses[1].max() < 0.9951 and (uses[1] > 0.95).all()
    fastest = shortest_stop_time(c[1], 2.0 * c[2] + now * c[1], path.limits)
    assert fastest <= profiles[3].duration < 1.06 * fastest
    for profile in profiles:  # exactly at rest where they end
        last = profile.at(profile.duration - 1e-9)
        assert last[:2] == pytest.approx((profile.end, 0.0), abs=1e-7)


@pytest.mark.parametrize("margin", [0.9, 0.3])
def test_bounds_of_path_acceleration_and_jerk_are_those_of_all_coordinates(rng, margin):
    # Polynomials of the fourth degree: their third derivative changes linearly from node to node.
    c, (bound, jerk) = rng.normal(size=(5, 3)), rng.uniform(1.0, 6.0, (2, 3))
    one = np.ones(3)
    joints = MotionLimits(-9 * one, 9 * one, 9 * one, bound, jerk, one)
    path = LimitedPath(polynomials(c), PathLimits(joints, np.empty((3, 0))), 1.0)
    limits, fresh = (DecelerationLimits(path, 0.2, 0.01, None) for _ in range(2))
    limits.margin = margin
    assert limits.extend(20) and limits.extend(500) and not limits.extend(500)
    assert len(limits.nodes()) == 82  # from 0.2 to 1, and one beyond the end
    s, v, u = 0.2 + np.array([0.07, 0.203, 0.618]), np.array([0.4, 0.9, 1.3]), np.array([-2, 0, 1])
    rows = limits.at(s)
    assert np.array_equal(fresh.at(s), rows)
    assert limits.at(np.array([1.05])) == pytest.approx(limits.nodes(81))
    assert limits.nodes(81)[0, :3] == pytest.approx(path.evaluate(np.ones(1))[1][0])  # of the end
    (_, d1, d2), steps = (
        path.evaluate(s),
        [polyval(s + h, polyder(c, 3)).T for h in (-5e-3, 5e-3)],
    )

    def interval(factor, rest, limit):
        """Return the lowest and highest x with |factor x + rest| <= limit, for all coordinates."""
        ends = np.sort([(-limit - rest) / factor, (limit - rest) / factor], axis=0)
        return ends[0].max(), ends[1].min()

    found = limits.jerk_bounds(rows, v, u)
    low = limits.min_acceleration(rows, v[:, np.newaxis])
    for i in range(3):
        own = np.abs(d2[i] * v[i] ** 2)  # where the path itself takes more, it may go on
        expected = interval(d1[i], d2[i] * v[i] ** 2, np.maximum(margin * bound, own))[0]
        assert low[i] == pytest.approx(min(expected, 0.0), abs=2e-3)
        rest, turn = np.array([d3[i] for d3 in steps]) * v[i] ** 3, 3.0 * d2[i] * v[i]
        limit = np.maximum(margin * jerk, np.abs(rest).max(axis=0))
        expected = [
            *interval(d1[i], rest + turn * u[i], limit),
            (limit / np.abs(d1[i])).min(), interval(turn, rest, limit)[0],
        ]  # fmt: skip
        np.testing.assert_allclose([bounds[i] for bounds in found], expected, rtol=3e-3)


def test_efforts_bound_the_path_acceleration_together_with_gravity_damping_and_friction():
    # 2 kg m2 q'' = tau - 5 q' - 1.5 + 2 g cos q, on q = 0.3 - s + 0.4 s^2 downwards and upwards.
    model = pendulum(gravity=-9.81, effort=40.0, damping=5.0)
    model.friction[:] = 1.5

    def evaluate(s):
        s = s[:, np.newaxis]
        return 0.3 - s + 0.4 * s * s, 0.8 * s - 1.0, 0.8 * np.ones_like(s)

    path = LimitedPath(evaluate, PathLimits(model.limits, np.empty((3, 0))), 1.0)
    limits, v = DecelerationLimits(path, 0.0, 0.05, model), np.array([[0.0, 0.5, 1.5]])
    limits.margin = 0.9
    limits.extend(15)
    s = 0.05 * np.arange(15)
    q, d1, d2 = evaluate(s)
    rest = 2.0 * d2 * v * v + 5.0 * d1 * v - 2.0 * 9.81 * np.cos(q) - 1.5
    most = 0.9 * 0.98 * 40.0
    expected = np.maximum((most - rest) / (2.0 * d1), -90.0 / np.abs(d1) - d2 * v * v / d1)
    np.testing.assert_allclose(limits.min_acceleration(limits.nodes(), v), expected, rtol=1e-2)
