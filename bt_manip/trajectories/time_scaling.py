"""Changing the pace of a motion while it goes on.

A trajectory is a path over its own time: with the pace ``p`` and its change ``u`` the joints move
with ``v p`` and ``a p^2 + v u``. So the greatest ``u`` of either sign that acceleration and effort
allow is known at each moment, and the fastest change of the pace is found by going forward once.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from bt_manip.robots import JointLimits, RobotModel

from .effort import ALLOWED
from .limit_check import (
    CONTROL_STEP,
    EFFORT_STEP,
    effort_use,
    greatest_effort,
    jumps,
    sample_times,
    sampled_limit_use,
)
from .motion_profile import MotionProfile, check_duration, profile_to_velocity
from .stopping import halt
from .trajectory import Samples, TimeScaledTrajectory, Trajectory

POINTS = 160  # at which the limits are looked at
NODE = 5e-3  # [s] the pace's change is linear between nodes, and averaged over two of these
MOST_NODES = 400
MARGINS = (0.995, 0.97, 0.9, 0.8, 0.6, 0.4, 0.2)  # of what is left of the limits
BRISK = 0.8  # of these, the least that needs not be improved on
RISES = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)  # [s] in which the pace rises where nothing else does
STEEPEST = 100.0  # [1/s] change of the pace
_SHIFTED = 0.25  # of a change, that is taken out of it in proportion
_TINY = 1e-9


class Change(NamedTuple):
    """A change of the pace.

    Attributes:
        trajectory: Makes it.
        brisk: Whether it makes about as much use of the limits as there is; it is slower where
            a joint brakes with nearly all it has, or the pace is changing fast already.
    """

    trajectory: TimeScaledTrajectory
    brisk: bool


def change_speed_scale(
    whole: Trajectory, clock: tuple[float, float, float], pace: float, model: RobotModel
) -> Change | None:
    """Change the pace of a trajectory inside all limits, about as quickly as these let.

    Args:
        whole: What is being driven.
        clock: Its time now, the pace and the pace's change: [s], [-] and [1/s].
        pace: From then on, 0 to 1; 0 comes to rest.
        model: The arm with its payload.

    Returns:
        None where the limits allow no change now, as while a joint brakes with all it has already
        or shortly before the end.

    Raises:
        MotionError: When it would go on for too long.
    """
    now, present, change = clock
    if now >= whole.duration:
        return None
    if pace > 0.0:
        check_duration((whole.duration - now) / pace)
    if present == pace and change == 0.0:
        return Change(at_speed_scale(whole, now, pace), True)
    if pace == 0.0:
        left = (whole.duration - now) / max(present, _TINY)
        halted = halt(whole, clock, model, left)
        return None if halted is None else Change(halted, True)
    trials = _changed(whole, clock, pace, model)
    for margin, (trial, changing) in zip(MARGINS, trials, strict=True):
        if _inside(trial, changing, pace, model):
            return Change(trial, margin >= BRISK)
    for trial, changing in _risen(whole, now, pace) if present == change == 0.0 else ():
        if _inside(trial, changing, pace, model):
            return Change(trial, False)
    return None


def at_speed_scale(whole: Trajectory, now: float, pace: float) -> TimeScaledTrajectory:
    """Go on along a trajectory from a time of its own [s], at a pace that stays."""
    left, end = (0.0, now) if pace == 0.0 else ((whole.duration - now) / pace, whole.duration)
    return TimeScaledTrajectory(whole, MotionProfile([[0.0, now, pace, 0.0, 0.0]], left, end))


def _inside(trial: TimeScaledTrajectory, changing: float, pace: float, model: RobotModel) -> bool:
    """Tell whether a change of the pace keeps to the limits.

    Args:
        trial: A trajectory whose pace changes first, and stays then.
        changing: For how long it changes [s].
        pace: What it is then: there the trajectory does what it does as a whole, more slowly.
        model: The arm with its payload.
    """
    times = sample_times(min(changing, trial.duration), CONTROL_STEP)
    rows = trial.sample(times)
    if trial.time_scaling.sample(times)[1].min() < 0.0 or not _kept(rows, model.limits):
        return False
    first = np.arange(0.0, changing, EFFORT_STEP)
    times = np.concatenate([first, np.arange(changing, trial.duration, EFFORT_STEP / pace)])
    effort = greatest_effort(model, *trial.sample(times))
    return effort <= ALLOWED or effort <= effort_use(trial.nominal, model)


def _risen(
    whole: Trajectory, now: float, pace: float
) -> Iterator[tuple[TimeScaledTrajectory, float]]:
    """Raise the pace from rest more and more gently: at last no limit is in the way."""
    for time in RISES:
        rate = pace / time
        rise = profile_to_velocity((now, 0.0, 0.0), pace, (2.0 * rate, 8.0 * rate / time))
        segments = [*rise.get_state()["segments"], [rise.duration, rise.end, pace, 0.0, 0.0, 0.0]]
        left = max(0.0, whole.duration - rise.end) / pace
        clock = MotionProfile(segments, rise.duration + left, max(whole.duration, rise.end))
        yield TimeScaledTrajectory(whole, clock), rise.duration


def _kept(rows: Samples, limits: JointLimits) -> bool:
    """Tell whether what is done at all control steps keeps to the limits of the motion."""
    inside = sampled_limit_use(rows, limits)._replace(position=0.0).inside
    return inside and not jumps(rows, limits.jerk)


def _changed(
    whole: Trajectory, clock: tuple[float, float, float], pace: float, model: RobotModel
) -> Iterator[tuple[TimeScaledTrajectory, float]]:
    """Change the pace with all that the limits leave, and then with less.

    Returns:
        Trajectories, and for how long their pace changes [s].
    """
    now, present, _ = clock
    moments = np.linspace(now, whole.duration, POINTS)
    rates, squares, limits = _constraints(whole, moments, model)
    for margin in MARGINS:
        speed = _change(rates, squares, limits, moments, present, pace, margin)
        profile, changing = _smoothed(moments, speed, clock, whole.duration)
        yield TimeScaledTrajectory(whole, profile), changing


def _constraints(
    whole: Trajectory, moments: np.ndarray, model: RobotModel
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Write the limits at each moment as ``|rates u + squares p^2 + rest| <= bound``.

    Returns:
        The rates, the squares, and the pair of lower and upper limits, the rest moved there.
    """
    q, v, a = whole.sample(moments)
    still = np.zeros(model.nq)
    gravity = np.array([model.rnea(x, still, still) for x in q])
    inertia = np.array([model.rnea(x, still, y) for x, y in zip(q, v, strict=True)])
    motion = np.array([model.rnea(*row) for row in zip(q, v, a, strict=True)])
    free = ALLOWED * model.limits.effort - model.friction - model.damping * np.abs(v)
    bound = np.broadcast_to(model.limits.acceleration, v.shape)
    return (
        np.hstack([v, inertia - gravity]),
        np.hstack([a, motion - gravity]),
        np.stack([np.hstack([-bound, -free - gravity]), np.hstack([bound, free - gravity])]),
    )


def _change(
    rates: np.ndarray,
    squares: np.ndarray,
    limits: np.ndarray,
    moments: np.ndarray,
    present: float,
    pace: float,
    margin: float,
) -> np.ndarray:
    """Give the pace at each moment of the trajectory, changed as fast as the limits allow."""
    speed = np.full(len(moments), pace)
    sign = 1.0 if pace > present else -1.0
    step = moments[1] - moments[0]
    moves = np.abs(rates) > _TINY
    safe = np.where(moves, rates, 1.0)
    z = present * present
    for i in range(len(moments)):
        speed[i] = np.sqrt(z)
        if sign * (pace - speed[i]) <= 0.0:
            speed[i:] = pace
            break
        low = (margin * limits[0, i] - squares[i] * z) / safe[i]
        high = (margin * limits[1, i] - squares[i] * z) / safe[i]
        bound = np.maximum(low, high) if sign > 0.0 else np.minimum(low, high)
        allowed = float((sign * bound)[moves[i]].min(initial=STEEPEST))
        z = max(0.0, z + sign * 2.0 * step * float(np.clip(margin * allowed, 0.0, STEEPEST)))
    return speed


def _smoothed(
    moments: np.ndarray, speed: np.ndarray, clock: tuple[float, float, float], end: float
) -> tuple[MotionProfile, float]:
    """Make a clock of paces: its change is averaged over two nodes and linear between them.

    Returns:
        The clock, and for how long its pace changes [s].
    """
    now, present, change = clock
    last = int((speed != speed[-1]).sum())  # from there on it stays
    middle = np.maximum(0.5 * (speed[1 : last + 1] + speed[:last]), 1e-4)
    t = np.concatenate([[0.0], np.cumsum(np.diff(moments[: last + 1]) / middle)])
    node = max(NODE, t[-1] / MOST_NODES)
    n = int(np.ceil(t[-1] / node)) + 2
    times = node * np.arange(-2, n + 3)
    paces = np.interp(times, t, speed[: last + 1])
    paces[times < 0.0] = present + change * times[times < 0.0]
    u = np.zeros(n + 3)
    u[1:-1] = (paces[3:-1] - paces[1:-3]) / (2.0 * node)
    u[0] = change
    # What the averaging has shifted is taken out of the whole change, so that it ends at the pace.
    wanted = float(paces[-1]) - present - 0.5 * node * change
    got = float(node * u[1:].sum())
    if abs(wanted - got) < _SHIFTED * abs(got):
        u[1:] *= wanted / got
    else:  # most of it is what was going on before
        hat = np.minimum(np.arange(n + 3), np.arange(n + 3)[::-1])
        u[1:] += (wanted - got) / (node * hat.sum()) * hat[1:]
    jerk = np.diff(u) / node
    velocity = present + np.concatenate([[0.0], np.cumsum(0.5 * node * (u[1:] + u[:-1]))])
    moved = node * (velocity[:-1] + node * (u[:-1] / 2.0 + node * jerk / 6.0))
    position = now + np.concatenate([[0.0], np.cumsum(moved)])
    rows = np.column_stack([node * np.arange(n + 2), position[:-1], velocity[:-1], u[:-1], jerk])
    segments = rows.tolist()
    changing = duration = node * (n + 2)
    reading, pace = float(position[-1]), float(paces[-1])
    if reading < end:
        segments.append([duration, reading, pace, 0.0, 0.0])
        duration, reading = duration + (end - reading) / pace, end
    return MotionProfile(segments, duration, reading), changing
