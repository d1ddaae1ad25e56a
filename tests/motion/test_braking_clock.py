"""Clocks that linear programmes change: what they do, and what their limits are near them."""

import numpy as np
import pytest

from bt_manip.motion.bounds import Bounds
from bt_manip.motion.braking.clock import Clock
from bt_manip.motion.braking.clock_limits import Curve
from bt_manip.motion.braking.near_clock import NearClock
from bt_manip.motion.braking.rows import Looks, Places
from bt_manip.motion.braking.stretches import Stretches, corners_passed, stretched
from bt_manip.motion.jerk_profile import JerkProfile, joint_profiles
from bt_manip.motion.trajectory import JointTrajectory

STATE = (0.3, 1.0, -0.4)


@pytest.fixture
def clock(rng):
    return clock_of(rng.uniform(0.01, 0.02, 12), rng.uniform(-8.0, 0.0, 13), rng.normal(size=12))


def clock_of(h, u, bow):
    u[0], u[-1] = STATE[2], 0.0
    return Clock(STATE, h, u, bow)


@pytest.fixture
def motion(rng):
    bounds = Bounds(*(np.full(7, most) for most in (3.14, 20.0, 500.0)))
    start = np.zeros(7), rng.uniform(-3.0, 3.0, 7), np.zeros(7)
    whole = JointTrajectory(joint_profiles(start, rng.uniform(-1.0, 1.0, 7), *bounds))
    return Curve(whole.table, bounds, whole.duration, whole.corners())


def changed(clock, rng, size):
    """Give a clock that is a little different, and by how much each of its variables is."""
    h, u, bow = clock.h.copy(), clock.u.copy(), clock.bow.copy()
    h *= 1.0 + size * rng.normal(size=len(h))
    u[1:-1] += size * rng.normal(size=len(u) - 2)
    bow += size * rng.normal(size=len(bow))
    other = Clock(STATE, h, u, bow)
    return other, {name: getattr(other, name) - getattr(clock, name) for name in "ups"} | {
        "h": h - clock.h,
        "bow": bow - clock.bow,
    }


def test_a_clock_that_is_driven_does_what_it_does_within_its_steps(clock, rng):
    t = rng.uniform(0.0, clock.t[-1], 200)
    now = clock.at(t)
    s, p, u = clock.profile().table(t)
    np.testing.assert_allclose(now.s, s, atol=1e-13)
    np.testing.assert_allclose(now.p, p, atol=1e-13)
    np.testing.assert_allclose(now.u, u, atol=1e-11)


def test_the_pace_is_how_fast_the_reading_grows_and_so_on(clock):
    near, inside = 1e-6, clock.t[:-1] + 0.37 * clock.h
    before, now, behind = (clock.at(inside + moved) for moved in (-near, 0.0, near))
    np.testing.assert_allclose((behind.s - before.s) / (2.0 * near), now.p, rtol=1e-8)
    np.testing.assert_allclose((behind.p - before.p) / (2.0 * near), now.u, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose((behind.u - before.u) / (2.0 * near), now.w, rtol=1e-6)


def test_what_a_clock_does_changes_as_its_rates_say(clock, rng):
    k, part = np.arange(12), rng.uniform(0.0, 1.0, 12)
    now = clock.within(k, part)
    other, moved = changed(clock, rng, 1e-6)
    for name, was, is_now in zip("spuw", now, other.within(k, part), strict=False):
        rates = now.rates[name].items()
        said = sum(rate * moved[of][k + behind] for (of, behind), rate in rates)
        np.testing.assert_allclose(is_now - was, said, rtol=1e-3, atol=1e-9)


def test_a_clock_passes_corners_at_their_nodes_and_rests_at_the_last(rng):
    stretches = Stretches(np.array([0.33, 0.36]), np.array([0, 3, 7, 12]))
    h, u = rng.uniform(0.01, 0.02, 12), np.linspace(-3.0, -9.0, 13)
    u[-1] = 0.0
    found = stretches.paced(STATE, h, u, np.zeros(12))
    np.testing.assert_allclose(found.s[[3, 7]], [0.33, 0.36], rtol=1e-12)
    assert found.p[-1] == pytest.approx(0.0, abs=1e-12)
    ratios = found.h / h  # the same within each stretch
    for first, last in ((0, 3), (3, 7), (7, 12)):
        np.testing.assert_allclose(ratios[first:last], ratios[first])


def test_a_clock_that_would_rest_before_a_corner_is_none():
    stretches = Stretches(np.array([5.0]), np.array([0, 3, 6]))
    u = np.array([-0.4, -9.0, -9.0, -9.0, -9.0, -9.0, 0.0])
    assert stretches.paced(STATE, np.full(6, 0.01), u, np.zeros(6)) is None


def test_a_clock_gets_nodes_at_the_corners_that_it_passes(motion):
    t = np.linspace(0.0, 0.4, 31)
    clock = Clock.braking_all(
        (0.1, 1.0, 0.0), np.diff(t), -np.sin(np.pi * t / 0.4), np.zeros(len(t) - 1)
    )
    stretches, found = stretched(motion, (0.1, 1.0, 0.0), clock, 1.0, 40)
    assert len(stretches.corners) > 3
    np.testing.assert_allclose(found.s[stretches.at_corners], stretches.corners, rtol=1e-12)
    assert found.t[-1] == pytest.approx(0.4, rel=0.02)
    assert stretches.fits(motion, found, 1.0)


def test_a_clock_that_never_goes_fast_passes_no_corner_that_matters(motion):
    clock = Clock.braking_all((0.1, 0.01, 0.0), np.full(8, 0.05), -np.ones(9), np.zeros(8))
    corners, times = corners_passed(motion, clock, 0.02)
    assert not len(corners) and not len(times)


@pytest.mark.parametrize("timed", [True, False])
def test_limits_near_a_clock_change_as_their_rates_say(motion, model, rng, timed):
    near = NearClock(motion._replace(timed=timed), STATE, model, 1.0)
    t = np.linspace(0.0, 0.3, 31)
    guess = Clock.braking_all(STATE, np.diff(t), -np.sin(np.pi * t / 0.3), np.zeros(30))
    stretches, clock = stretched(motion, STATE, guess, near.pace, 30)
    errors = []
    for size in (1e-5, 5e-6):
        h, u, bow = clock.h, clock.u + size * np.sin(clock.t / 0.01), clock.bow
        other = stretches.paced(STATE, h, np.append(u[:-1], 0.0), bow)
        moved = {name: getattr(other, name) - getattr(clock, name) for name in ("u", "p", "s")}
        moved |= {"h": other.h - clock.h, "bow": other.bow - clock.bow}
        before, behind = (near.closely(one, Looks.nowhere(), 0) for one in (clock, other))
        off = [
            np.abs(b.value - a.value - sum(
                rate * moved[of][a.at + later][:, None] for (of, later), rate in a.rates.items()
            )) / a.most
            for a, b in zip(before, behind, strict=True)
        ]  # fmt: skip
        errors.append(np.median(np.concatenate([one.max(axis=1) for one in off])))
    assert errors[1] < 0.35 * errors[0] + 1e-10  # what is left is of the second order


def test_the_worst_place_of_each_step_that_is_beyond_is_looked_at():
    excess = np.full((3, 5, 2), -1.0)
    excess[1, 2, 0], excess[1, 3, 0] = 0.1, 0.3
    found = Places.along(np.arange(0), 0.0).worst(excess)
    assert (found.k.tolist(), found.part.tolist()) == ([1], [0.75])
    assert len(found.worst(excess).k) == 1  # and only once


def test_a_profile_whose_jerk_changes_evenly_is_what_its_derivatives_say():
    profile = JerkProfile(
        [[0.0, 0.1, 0.2, -0.3, 4.0, -50.0], [0.2, 0.1, 0.0, 1.0, 0.0, 7.0]], 0.5, 1.0
    )
    near, t = 1e-5, np.array([0.05, 0.15, 0.3])
    (s0, v0, a0), (s1, v1, a1), (s2, v2, a2) = (profile.table(t + x) for x in (-near, 0.0, near))
    np.testing.assert_allclose((s2 - s0) / (2.0 * near), v1, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose((v2 - v0) / (2.0 * near), a1, rtol=1e-7)
    np.testing.assert_allclose((a2 - a0) / (2.0 * near), [1.5, -3.5, 0.7], rtol=1e-6)
    for i in range(3):
        assert profile.sample(float(t[i])) == pytest.approx((s1[i], v1[i], a1[i]), rel=1e-12)
    slower = profile.slowed(2.0)
    assert slower.sample(0.3)[2] == pytest.approx(profile.sample(0.15)[2] / 4.0, rel=1e-12)
    again = JerkProfile.from_state(profile.get_state())
    assert again.sample(0.3) == profile.sample(0.3)
