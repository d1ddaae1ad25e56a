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

from .kinematic_limits import KinematicLimits
from .motion_profile import MotionProfile
from .time_scaling_limits import ClockLimits, Curve, Rates, State

STEP = 1e-3  # [s] in which the clock's jerk is constant
FINEST = 1e-4  # [s] for halts that are short
FEWEST_STEPS, MOST_STEPS = 100, 400
MARGINS = (0.995, 0.97, 0.93, 0.85)  # fractions of the limits
ROUNDS = 5
SETTLED = 1e-3  # of the duration, below which another round changes nothing
LEAST = 0.1  # of the greatest jerk of a clock that is about to rest, for coming back to nought
LANDING = 0.97  # of the limits of jerk, for coming back to nought
EVERY = 2  # nodes, for the first guess
LEVELS = 8  # paces that the lowest change is looked up between, for the first guess
_TINY = 1e-9


def shortest_rest(v: np.ndarray, a: np.ndarray, bounds: KinematicLimits) -> float:
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
    curve: Curve,
    state: State,
    model: RobotModel | None = None,
    allowed: float = 1.0,
    left: float = np.inf,
) -> Iterator[MotionProfile]:
    """Bring a clock to rest, braking as hard as the limits allow; and less hard.

    Whether the limits are kept is for the caller to see: a clock may be a little outside, and then
    another round, or a smaller fraction of the limits, helps.

    Args:
        curve: What the clock goes through, inside its limits at pace 1.
        state: Its reading, its pace and the pace's change.
        model: The arm with its payload; None does not look at efforts.
        allowed: Fraction of the limits of effort that may be used.
        left: Clocks that take longer are not looked for [s].

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
    first = _guess(limits, state, least, curve.end)
    if first is None:
        return
    course = first
    for limits.margin in MARGINS:
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
        if clock.duration > left:
            return


class _Course:
    """Readings, paces and changes of the pace at equal steps of time."""

    def __init__(self, step: float, s: np.ndarray, p: np.ndarray, u: np.ndarray) -> None:
        self.step, self.s, self.p, self.u = step, s, p, u
        # Where a clock without jerk has to keep the limits.
        self.still = np.zeros(len(s), dtype=bool)


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
) -> tuple[MotionProfile, _Course] | None:
    """Brake as hard as all limits allow that hold along a course; None where the end is nearer."""
    rows = limits.at(course.s)
    low = limits.lowest(rows, course.p[:, np.newaxis])[:, 0]
    rates = limits.rates(rows, course.p, course.u)
    narrow = rates.fall > rates.rise  # no jerk of the clock is right for all coordinates
    narrow[1:-1] |= narrow[2:] | narrow[:-2]
    course.still |= narrow
    low = np.where(course.still, np.maximum(low, rates.lowest), low)
    rates = rates._replace(
        fall=np.where(course.still, np.minimum(rates.fall, 0.0), rates.fall),
        rise=np.where(course.still, np.maximum(rates.rise, 0.0), rates.rise),
    )
    wide = low.copy()  # what lies between two nodes is as low as the higher of them at most
    wide[1:] = np.maximum(wide[1:], low[:-1])
    wide[:-1] = np.maximum(wide[:-1], low[1:])
    u = _within(wide, rates, state[2], course.step)
    rise = LANDING * np.maximum(rates.rise, LEAST * rates.steepest)
    rest = int(np.count_nonzero(course.p > 0.0))
    found = _landed(state, u, rise[: rest + 1], course.step, end)
    if found is not None:
        found[1].still = course.still
    return found


def _within(low: np.ndarray, rates: Rates, now: float, h: float) -> np.ndarray:
    """Give the lowest change of the pace above ``low`` that falls and rises as jerk allows."""
    rise = np.minimum(rates.rise[1:], rates.rise[:-1])
    fall = np.maximum(rates.fall[1:], rates.fall[:-1])
    risen = np.concatenate([[0.0], np.cumsum(h * rise)])
    fallen = np.concatenate([[0.0], np.cumsum(h * fall)])
    in_time = np.maximum.accumulate((low - risen)[::-1])[::-1] + risen
    in_time[0] = now
    return np.asarray(np.maximum.accumulate(in_time - fallen) + fallen)


def _landed(
    state: State, u: np.ndarray, rise: np.ndarray, h: float, end: float
) -> tuple[MotionProfile, _Course] | None:
    """Follow changes of the pace until the greatest jerk is only just enough to rest.

    Args:
        state: Where the clock is.
        u: The changes of the pace at equal steps; all of this is written in these.  # (n,)
        rise: The greatest jerk at the same times, until the course before was at rest.  # (m,)
        h: The step [s].
        end: The last reading.
    """
    # What is left of the pace and its change, some steps before rest.
    back = np.pad(rise[::-1], (0, len(u)), mode="edge")
    change = np.concatenate([[0.0], np.cumsum(0.5 * h * (back[1:] + back[:-1]))])
    left = np.concatenate([[0.0], np.cumsum(0.5 * h * (change[1:] + change[:-1]))])
    p = state[1] + 0.5 * h * np.concatenate([[0.0], np.cumsum(u[1:] + u[:-1])])
    spare = p - np.interp(-u, change, left)
    lands = (u[1:] < 0.0) & (spare[1:] < 0.0)
    i = int(lands.argmax())
    if not lands[i]:
        return None
    part = float(np.clip(spare[i] / (spare[i] - spare[i + 1]), 0.0, 1.0))
    low = float(u[i] + part * (u[i + 1] - u[i]))
    pace = float(p[i]) + 0.5 * part * h * (float(u[i]) + low)
    if not low < 0.0 < pace:
        return None
    takes = float(np.interp(-low, change, h * np.arange(len(change))))
    steps = max(1, int(np.ceil(takes / h)))
    share = np.arange(1, steps + 1) / steps
    landing = -np.interp(takes * (1.0 - share), h * np.arange(len(change)), change)
    landing[-1] = 0.0
    takes *= pace / -(0.5 * takes / steps * (low + 2.0 * float(landing.sum())))
    t = np.concatenate([h * np.arange(i + 1), h * (i + part) + takes * np.append(0.0, share)])
    return _clock(
        state, t, np.concatenate([u[: i + 1], [low], landing]), h * np.arange(len(u)), end
    )


def _clock(
    state: State, t: np.ndarray, u: np.ndarray, times: np.ndarray, end: float
) -> tuple[MotionProfile, _Course] | None:
    """Make a clock of changes of the pace; None where the end is nearer than its rest."""
    s, pace, _ = state
    new = np.append(True, np.diff(t) > _TINY)
    t, u = t[new], u[new]
    dt = np.diff(t)
    jerk = np.diff(u) / dt
    p = pace + np.concatenate([[0.0], np.cumsum(0.5 * dt * (u[1:] + u[:-1]))])
    moved = dt * (p[:-1] + dt * (u[:-1] / 2.0 + dt * jerk / 6.0))
    reading = s + np.concatenate([[0.0], np.cumsum(moved)])
    if reading[-1] > end:
        return None
    rows = np.column_stack([t[:-1], reading[:-1], p[:-1], u[:-1], jerk])
    clock = MotionProfile(rows.tolist(), float(t[-1]), float(reading[-1]))
    p[-1] = 0.0
    course = (np.interp(times, t, column) for column in (reading, p, u))
    return clock, _Course(float(times[1]), *course)
