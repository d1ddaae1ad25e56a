"""Search for the fastest stop on a path.

A forward pass integrates the greatest path deceleration that acceleration and effort limits allow,
ignoring jerk limits. Along the resulting profile all limits are functions of time: the path
acceleration is limited in slope by the path jerk they allow. That changes the profile a little, so
it is repeated until the limits are kept.
"""

from collections.abc import Iterator
from math import sqrt
from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from .deceleration_limits import DecelerationLimits, JerkBounds, LimitedPath
from .motion_profile import MotionProfile, ScalarState, integrate_acceleration
from .path_limits import TINY, PathLimits

STOP_STEP = 1e-3  # [s] of constant path jerk
MIN_STEP = 1e-4  # [s] for short stops
MIN_STEPS, MAX_STEPS = 100, 250  # of a stop; the latter bounds the computing
STOP_MARGINS = (0.995, 0.995, 0.995, 0.995, 0.96, 0.96, 0.9)
"""Fractions of the limits that are used, one per iteration.

Nearly all searches converge within four; what exceeds a limit then usually does so by less than
4 %.
"""

MIN_FINAL_JERK = 0.1  # of the greatest path jerk at rest, for the last phase
FINAL_JERK = 0.97  # of the highest path jerk, for the last phase
GUESS_EVERY = 2  # nodes that the forward pass takes at once
GUESS_LEVELS = 8  # path velocities between which its lowest acceleration is interpolated


def shortest_stop_time(v: np.ndarray, a: np.ndarray, limits: PathLimits) -> float:
    """Return the longest of the times that each coordinate alone needs to stop [s].

    No stop on the path can be faster.

    Args:
        v: Velocities.  # (m,)
        a: Accelerations.  # (m,)
        limits: Limits of the coordinates.
    """
    bound, jerk = limits.acceleration, limits.jerk
    forward = np.where(v + a * np.abs(a) / (2.0 * jerk) < 0.0, -1.0, 1.0)
    v, a = forward * v, forward * a
    peak = np.sqrt(np.maximum(jerk * v + 0.5 * a * a, 0.0))
    saturated = (a + 2.0 * bound) / jerk + (v + (0.5 * a * a - bound * bound) / jerk) / bound
    return float(np.where(peak <= bound, (a + 2.0 * peak) / jerk, saturated).max())


def stop_profiles(
    path: LimitedPath, start: ScalarState, model: RobotModel | None = None
) -> Iterator[MotionProfile]:
    """Yield at most ``len(STOP_MARGINS)`` profiles of s that stop as fast as the limits allow.

    The caller checks the limits: an early profile may exceed them a little.

    Args:
        path: The path.
        start: s, s_dot and s_ddot.
        model: The arm with its payload; None ignores efforts.
    """
    s, s_dot, s_ddot = start
    ramp = float((path.limits.acceleration / path.limits.jerk).max())
    fastest = s_dot + max(0.0, s_ddot) * ramp
    if fastest <= TINY:
        return
    _, d1, d2 = (rows[0] for rows in path.evaluate(np.array([s])))
    shortest = shortest_stop_time(d1 * s_dot, d2 * s_dot * s_dot + d1 * s_ddot, path.limits)
    limits = DecelerationLimits(path, s, fastest * STOP_STEP, model)
    samples = _first_guess(limits, start, shortest, path.end)
    for limits.margin in STOP_MARGINS:
        found = None if samples is None else _iterate(limits, start, samples, path.end)
        if found is None:
            return
        profile, samples = found
        yield profile


class _Samples(NamedTuple):
    """A profile at equal time steps.

    Attributes:
        step: Time step [s].
        states: s, s_dot and s_ddot.  # (3, n)
        no_jerk: Where the limits have to be kept without path jerk.  # (n,)
    """

    step: float
    states: np.ndarray
    no_jerk: np.ndarray


def _first_guess(
    limits: DecelerationLimits, start: ScalarState, shortest: float, end: float
) -> _Samples | None:
    """Integrate the greatest deceleration, ignoring jerk; None when the path ends before."""
    s, fastest = start[0], max(start[1], TINY)
    levels = np.linspace(0.0, fastest, GUESS_LEVELS + 1)
    apart = float(levels[1])

    def lowest(row: list[float], velocity: float) -> float:
        k = min(int(velocity / apart), GUESS_LEVELS - 1)
        return row[k] + (velocity / apart - k) * (row[k + 1] - row[k])

    rows: list[list[float]] = []
    velocities, spacing = [fastest], GUESS_EVERY * limits.spacing
    while velocities[-1] > 0.0:
        n, velocity = len(velocities) - 1, velocities[-1]
        if n + 1 >= len(rows):
            wanted = max(2 * GUESS_EVERY * len(rows), int(0.6 * shortest / STOP_STEP) + 10)
            if not limits.extend(wanted):
                return None
            new = limits.nodes(GUESS_EVERY * len(rows))[::GUESS_EVERY]
            rows += limits.min_acceleration(new, levels[np.newaxis]).tolist()
            continue
        here = lowest(rows[n], velocity)
        there = lowest(rows[n + 1], sqrt(max(0.0, velocity * velocity + 2.0 * spacing * here)))
        squared = velocity * velocity + spacing * (here + there)
        velocities.append(sqrt(squared) if squared > 0.0 else squared)
    part = velocities[-2] ** 2 / (velocities[-2] ** 2 - velocities[-1])
    velocities[-1] = 0.0
    v = np.array(velocities)
    moved = np.full(len(v) - 1, spacing)
    moved[-1] *= part
    t = np.concatenate([[0.0], np.cumsum(2.0 * moved / (v[1:] + v[:-1]))])
    acceleration = np.append(np.diff(v) / np.diff(t), 0.0)
    duration = max(float(t[-1]), shortest)
    step = max(MIN_STEP, min(STOP_STEP, duration / MIN_STEPS), duration / MAX_STEPS)
    times = step * np.arange(int(1.1 * duration / step) + 16)
    position = np.minimum(s + np.concatenate([[0.0], np.cumsum(moved)]), end)
    path = (np.interp(times, t, column) for column in (position, v, acceleration))
    return _Samples(step, np.array(list(path)), np.zeros(len(times), dtype=bool))


def _iterate(
    limits: DecelerationLimits, start: ScalarState, samples: _Samples, end: float
) -> tuple[MotionProfile, _Samples] | None:
    """Stop as fast as the limits along the samples allow; None when the path ends before."""
    s, s_dot, s_ddot = samples.states
    rows = limits.at(s)
    low = limits.min_acceleration(rows, s_dot[:, np.newaxis])[:, 0]
    bounds = limits.jerk_bounds(rows, s_dot, s_ddot)
    conflict = bounds.lowest > bounds.highest  # no path jerk suits all coordinates
    conflict[1:-1] |= conflict[2:] | conflict[:-2]
    no_jerk = samples.no_jerk | conflict
    low = np.where(no_jerk, np.maximum(low, bounds.constant), low)
    bounds = bounds._replace(
        lowest=np.where(no_jerk, np.minimum(bounds.lowest, 0.0), bounds.lowest),
        highest=np.where(no_jerk, np.maximum(bounds.highest, 0.0), bounds.highest),
    )
    padded = low.copy()  # between two nodes the higher of their bounds holds
    padded[1:] = np.maximum(padded[1:], low[:-1])
    padded[:-1] = np.maximum(padded[:-1], low[1:])
    new = _jerk_limited(padded, bounds, start[2], samples.step)
    final_jerk = FINAL_JERK * np.maximum(bounds.highest, MIN_FINAL_JERK * bounds.at_rest)
    moving = int(np.count_nonzero(s_dot > 0.0))
    motion = _with_final_phase(start, new, final_jerk[: moving + 1], samples.step)
    if motion is None or motion[-1, 1] > end:
        return None
    profile = MotionProfile(motion[:-1].tolist(), float(motion[-1, 0]), float(motion[-1, 1]))
    motion[-1, 2] = 0.0
    times = samples.step * np.arange(len(s))
    states = np.array([np.interp(times, motion[:, 0], motion[:, k]) for k in (1, 2, 3)])
    return profile, _Samples(samples.step, states, no_jerk)


def _jerk_limited(low: np.ndarray, bounds: JerkBounds, now: float, step: float) -> np.ndarray:
    """Return the lowest path acceleration above a bound that the path jerk allows."""
    highest = np.minimum(bounds.highest[1:], bounds.highest[:-1])
    lowest = np.maximum(bounds.lowest[1:], bounds.lowest[:-1])
    rise = np.concatenate([[0.0], np.cumsum(step * highest)])
    fall = np.concatenate([[0.0], np.cumsum(step * lowest)])
    above = np.maximum.accumulate((low - rise)[::-1])[::-1] + rise
    above[0] = now
    return np.asarray(np.maximum.accumulate(above - fall) + fall)


def _with_final_phase(
    start: ScalarState, s_ddot: np.ndarray, final_jerk: np.ndarray, step: float
) -> np.ndarray | None:
    """Follow path accelerations until the final path jerk just leads to rest, and then that.

    Args:
        start: s, s_dot and s_ddot.
        s_ddot: Path accelerations at equal time steps.  # (n,)
        final_jerk: Path jerk for the final phase at the same times, up to the end of the previous
            profile.  # (m,)
        step: Time step [s].

    Returns:
        Rows of `integrate_acceleration`; None where rest is not reached.
    """
    n = len(s_ddot)
    # Deceleration and path velocity left, a number of steps before rest.
    back = np.pad(final_jerk[::-1], (0, n), mode="edge")
    deceleration = np.concatenate([[0.0], np.cumsum(0.5 * step * (back[1:] + back[:-1]))])
    mean = 0.5 * (deceleration[1:] + deceleration[:-1])
    left = np.concatenate([[0.0], np.cumsum(step * mean)])
    gained = np.cumsum(0.5 * step * (s_ddot[1:] + s_ddot[:-1]))
    s_dot = start[1] + np.concatenate([[0.0], gained])
    spare = s_dot - np.interp(-s_ddot, deceleration, left)
    begins = (s_ddot[1:] < 0.0) & (spare[1:] < 0.0)
    i = int(begins.argmax())
    if not begins[i]:
        return None
    part = float(np.clip(spare[i] / (spare[i] - spare[i + 1]), 0.0, 1.0))
    low = float(s_ddot[i] + part * (s_ddot[i + 1] - s_ddot[i]))
    velocity = float(s_dot[i]) + 0.5 * part * step * (float(s_ddot[i]) + low)
    if not low < 0.0 < velocity:
        return None
    times_back = step * np.arange(len(deceleration))
    duration = float(np.interp(-low, deceleration, times_back))
    count = max(1, int(np.ceil(duration / step)))
    share = np.arange(1, count + 1) / count
    final = -np.interp(duration * (1.0 - share), times_back, deceleration)
    final[-1] = 0.0
    # So long that exactly the velocity that is left is lost.
    duration *= velocity / -(0.5 * duration / count * (low + 2.0 * float(final.sum())))
    t = np.concatenate(
        [step * np.arange(i + 1), step * (i + part) + duration * np.append(0.0, share)]
    )
    acceleration = np.concatenate([s_ddot[: i + 1], [low], final])
    distinct = np.append(True, np.diff(t) > TINY)
    return integrate_acceleration(start, t[distinct], acceleration[distinct])
