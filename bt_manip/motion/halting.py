"""The fastest way to bring a motion to rest on its own path.

A clock that brakes as hard as acceleration and effort allow at each reading is found by going
forward once, its jerk apart. Along it the limits are known as functions of time, and so is what
those of jerk make of them: the change of the pace falls no faster, and rises no later, than they
allow. That moves the clock a little, so it is done again until the limits are kept.
"""

from collections.abc import Iterator
from math import sqrt

import numpy as np

from bt_manip.robots import RobotModel

from .bounds import Bounds
from .clock_limits import ClockLimits, Curve, Rates
from .jerk_profile import JerkProfile

STEP = 1e-3  # [s] in which the clock's jerk is constant
FINEST = 1e-4  # [s] for halts that are short
FEWEST_STEPS, MOST_STEPS = 100, 400
MARGINS = (0.995, 0.97, 0.93, 0.85, 0.7, 0.5, 0.3)  # fractions of the limits
ROUNDS = 5
SETTLED = 1e-3  # of the duration, below which another round changes nothing
LANDING = 0.97  # of the limits of jerk, for coming back to nought
EVERY = 2  # nodes, for the first guess
LEVELS = 8  # paces that the lowest change is looked up between, for the first guess
_TINY = 1e-9

State = tuple[float, float, float]


def shortest_rest(v: np.ndarray, a: np.ndarray, bounds: Bounds) -> float:
    """Give the longest time that any coordinate needs to come to rest, each by itself [s].

    No path lets them all rest sooner: acceleration comes and goes at the greatest jerk.

    Args:
        v: Velocities.  # (m,)
        a: Accelerations.  # (m,)
        bounds: What the coordinates may do.  # (m,) each
    """
    most, jerk = bounds.acceleration, bounds.jerk
    ahead = np.where(v + a * np.abs(a) / (2.0 * jerk) < 0.0, -1.0, 1.0)
    v, a = ahead * v, ahead * a
    peak = np.sqrt(np.maximum(jerk * v + 0.5 * a * a, 0.0))
    full = (a + 2.0 * most) / jerk + (v + (0.5 * a * a - most * most) / jerk) / most
    return float(np.where(peak <= most, (a + 2.0 * peak) / jerk, full).max())


def halting_clocks(
    curve: Curve, state: State, model: RobotModel | None = None, allowed: float = 1.0
) -> Iterator[JerkProfile]:
    """Bring a clock to rest, braking as hard as the limits allow; and less hard.

    Whether the limits are kept is for the caller to see: a clock may be a little outside, and then
    another round, or a smaller fraction of the limits, helps.

    Args:
        curve: What the clock goes through, inside its limits at pace 1.
        state: Its reading, its pace and the pace's change.
        model: The arm with its payload; None does not look at efforts.
        allowed: Fraction of the limits of effort that may be used.

    Returns:
        Clocks that come to rest before the end.
    """
    s, p, u = state
    ramp = float((curve.bounds.acceleration / curve.bounds.jerk).max())
    fastest = p + max(0.0, u) * ramp
    if fastest <= _TINY:
        return
    _, d1, d2 = (rows[0] for rows in curve.evaluate(np.array([s])))
    least = shortest_rest(d1 * p, d2 * p * p + d1 * u, curve.bounds)
    limits = ClockLimits(curve, s, fastest * STEP, model, allowed)
    course: _Course | None = None
    for margin in MARGINS:
        limits.margin = margin
        if course is None:
            course = _guess(limits, state, least, curve.end)
            if course is None:
                return
        duration = 0.0
        for _ in range(ROUNDS):
            found = _again(limits, state, course, curve.end)
            if found is None:
                return
            clock, course = found
            yield clock
            if abs(clock.duration - duration) < SETTLED * duration:
                break
            duration = clock.duration


class _Course:
    """Readings, paces and changes of the pace at equal steps of time."""

    def __init__(self, step: float, s: np.ndarray, p: np.ndarray, u: np.ndarray) -> None:
        self.step, self.s, self.p, self.u = step, s, p, u


def _guess(limits: ClockLimits, state: State, least: float, end: float) -> _Course | None:
    """Brake as hard as acceleration and effort allow; None where the end comes first."""
    s, p, _ = state
    levels = np.linspace(0.0, max(p, _TINY), LEVELS + 1)
    apart = float(levels[1])

    def lowest(row: list[float], pace: float) -> float:
        k = min(int(pace / apart), LEVELS - 1)
        return row[k] + (pace / apart - k) * (row[k + 1] - row[k])

    rows: list[list[float]] = []
    paces, spacing = [p], EVERY * limits.spacing
    while paces[-1] > 0.0:
        n, pace = len(paces) - 1, paces[-1]
        if n + 1 >= len(rows):
            if not limits.extend(max(2 * EVERY * len(rows), int(0.6 * least / STEP) + 10)):
                return None
            new = limits.nodes(EVERY * len(rows))[::EVERY]
            rows += limits.lowest(new, levels[np.newaxis]).tolist()
            continue
        here = lowest(rows[n], pace)
        there = lowest(rows[n + 1], sqrt(max(0.0, pace * pace + 2.0 * spacing * here)))
        square = pace * pace + spacing * (here + there)
        paces.append(sqrt(square) if square > 0.0 else square)
    part = paces[-2] ** 2 / (paces[-2] ** 2 - paces[-1])
    paces[-1] = 0.0
    p_at = np.array(paces)
    moved = np.full(len(p_at) - 1, spacing)
    moved[-1] *= part
    t = np.concatenate([[0.0], np.cumsum(2.0 * moved / (p_at[1:] + p_at[:-1]))])
    change = np.append(np.diff(p_at) / np.diff(t), 0.0)
    duration = max(float(t[-1]), least)
    step = max(FINEST, min(STEP, duration / FEWEST_STEPS), duration / MOST_STEPS)
    times = step * np.arange(int(1.1 * duration / step) + 16)
    reading = np.minimum(s + np.concatenate([[0.0], np.cumsum(moved)]), end)
    return _Course(step, *(np.interp(times, t, rows) for rows in (reading, p_at, change)))


def _again(
    limits: ClockLimits, state: State, course: _Course, end: float
) -> tuple[JerkProfile, _Course] | None:
    """Brake as hard as all limits allow that hold along a course; None where the end is nearer."""
    rows = limits.at(course.s)
    low = limits.lowest(rows, course.p[:, np.newaxis])[:, 0]
    rates = limits.rates(rows, course.p, course.u)
    low = np.maximum(low, rates.lowest)
    wide = low.copy()  # what lies between two nodes is as low as the higher of them at most
    wide[1:] = np.maximum(wide[1:], low[:-1])
    wide[:-1] = np.maximum(wide[:-1], low[1:])
    u = _within(wide, rates, state[2], course.step)
    return _landed(state, u, LANDING * rates.steepest, course.step, end)


def _within(low: np.ndarray, rates: Rates, now: float, h: float) -> np.ndarray:
    """Give the lowest change of the pace above ``low`` that falls and rises as jerk allows."""
    rise = np.maximum(np.minimum(rates.rise[1:], rates.rise[:-1]), 0.0)
    fall = np.minimum(np.maximum(rates.fall[1:], rates.fall[:-1]), 0.0)
    risen = np.concatenate([[0.0], np.cumsum(h * rise)])
    fallen = np.concatenate([[0.0], np.cumsum(h * fall)])
    in_time = np.maximum.accumulate((low - risen)[::-1])[::-1] + risen
    in_time[0] = now
    return np.asarray(np.maximum.accumulate(in_time - fallen) + fallen)


def _landed(
    state: State, u: np.ndarray, steepest: np.ndarray, h: float, end: float
) -> tuple[JerkProfile, _Course] | None:
    """Follow changes of the pace until the greatest jerk is only just enough to rest at once."""
    s, pace, _ = state
    p = pace + 0.5 * h * np.concatenate([[0.0], np.cumsum(u[1:] + u[:-1])])
    lands = (u[1:] < 0.0) & (2.0 * p[1:] < u[1:] ** 2 / steepest[:-1])
    i = int(lands.argmax())
    if not lands[i]:
        return None
    # Inside this step: at its end the greatest jerk is to be just enough.
    jerk = float(steepest[i])
    low = (
        0.5 * jerk * (h - sqrt(h * h + 4.0 * max(0.0, 2.0 * float(p[i]) + h * float(u[i])) / jerk))
    )
    rest = float(p[i]) + 0.5 * h * (float(u[i]) + low)
    if low < 0.0 < rest:
        i += 1
        u[i], p[i] = low, rest
    change, rest = float(u[i]), float(p[i])
    if not change < 0.0 < rest:
        return None
    rates = np.diff(u) / h
    s_at = s + np.concatenate(
        [[0.0], np.cumsum(h * (p[:-1] + h * (u[:-1] / 2.0 + h * rates / 6.0)))]
    )
    ramp = -2.0 * rest / change
    jerk = -change / ramp
    t = h * np.arange(i + 1)
    rows = np.column_stack([t, s_at[: i + 1], p[: i + 1], u[: i + 1], np.append(rates[:i], jerk)])
    x = np.minimum(h * np.arange(len(u) - i), ramp)
    s_at[i:] = s_at[i] + x * (rest + x * (change / 2.0 + x * jerk / 6.0))
    p[i:] = np.maximum(rest + x * (change + x * jerk / 2.0), 0.0)
    u[i:] = change + x * jerk
    last = float(rows[-1, 1]) + ramp * (rest + ramp * (change / 2.0 + ramp * jerk / 6.0))
    if last > end:
        return None
    clock = JerkProfile(rows.tolist(), float(t[-1]) + ramp, last)
    return clock, _Course(h, s_at, p, u)
