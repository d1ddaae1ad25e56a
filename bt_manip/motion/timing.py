"""How fast a path may be driven."""

from typing import NamedTuple

import numpy as np

from bt_manip.robots import JointLimits, ToolLimits

from .jerk_profile import reach_profile
from .limit_check import limit_use
from .path_limits import PathLimits
from .paths import Path
from .trajectory import PathTrajectory

GRID = 200
FINE = 2.5e-4  # [s] sees the jerk whatever the phase of the control steps
_SPEEDS = (1.0, 0.85, 0.7, 0.55, 0.42, 0.3, 0.2, 0.12)  # fractions of the greatest path speed
_SHARES = (1.0, 0.8, 0.6, 0.4)  # of what is left for the path acceleration
_TINY = 1e-12


class ToolLine(NamedTuple):
    """What the tool does along a path: a straight line of this length [m] and turn [rad]."""

    length: float
    angle: float


def path_limits(
    path: Path,
    limits: JointLimits,
    *,
    line: ToolLine | None = None,
    tool: ToolLimits | None = None,
) -> PathLimits:
    """Find bounds for a path that let it be driven as fast as a few tries show.

    With q' for dq/ds: ``v = q' ds``, ``a = q'' ds^2 + q' dds``,
    ``jerk = q''' ds^3 + 3 q'' ds dds + q' ddds``.
    """
    _, d1, d2, d3 = (np.abs(x) for x in path.evaluate(np.linspace(0.0, 1.0, GRID + 1), 3))
    d1, d2, d3 = d1 + _TINY, d2 * 1.02, d3 * 1.02  # between the grid's points there is more
    greatest = float((limits.velocity / d1).min())
    tool_bounds = (np.inf, np.inf, np.inf)
    if line is not None and tool is not None:
        tool_bounds = (
            min(
                tool.velocity / (line.length + _TINY), tool.angular_velocity / (line.angle + _TINY)
            ),
            min(
                tool.acceleration / (line.length + _TINY),
                tool.angular_acceleration / (line.angle + _TINY),
            ),
            min(tool.jerk / (line.length + _TINY), tool.angular_jerk / (line.angle + _TINY)),
        )
    greatest = min(greatest, tool_bounds[0])
    if not d2.any() and not d3.any():
        return PathLimits(
            greatest,
            min(float((limits.acceleration / d1).min()), tool_bounds[1]),
            min(float((limits.jerk / d1).min()), tool_bounds[2]),
        )
    best, best_duration = PathLimits(0.0, 0.0, 0.0), np.inf
    for fraction in _SPEEDS:
        speed = fraction * greatest
        left = float(((limits.acceleration - d2 * speed**2) / d1).min())
        for share in _SHARES:
            acceleration = min(share * left, tool_bounds[1])
            if acceleration <= 0.0:
                continue
            rest = limits.jerk - d3 * speed**3 - 3.0 * d2 * speed * acceleration
            jerk = min(float((rest / d1).min()), tool_bounds[2])
            if jerk <= 0.0:
                continue
            duration = reach_profile((0.0, 0.0, 0.0), 1.0, (speed, acceleration, jerk)).duration
            if duration < best_duration:
                best, best_duration = PathLimits(speed, acceleration, jerk), duration
    return best


def drive(path: Path, bounds: PathLimits, braking: PathLimits) -> PathTrajectory:
    """Drive a path from rest at its start to rest at its end.

    Args:
        path: The curve.
        bounds: To drive it with.
        braking: To brake with, should it have to.
    """
    return PathTrajectory(path, reach_profile((0.0, 0.0, 0.0), 1.0, bounds), braking)


def tightened(
    path: Path, bounds: PathLimits, limits: JointLimits, line: ToolLine, tool: ToolLimits
) -> PathLimits:
    """Speed bounds up to what the driven trajectory allows, or slow them down to it.

    `path_limits` lets the worst of velocity, of acceleration and of curvature fall together; on
    the real trajectory they do not.
    """
    scale, best = 1.0, 0.0
    for _ in range(6):
        trial = bounds.scaled(scale)
        _, velocity, acceleration, jerk = limit_use(drive(path, trial, bounds), limits, FINE)
        tool_use = max(
            trial.velocity * line.length / tool.velocity,
            trial.velocity * line.angle / tool.angular_velocity,
            (trial.acceleration * line.length / tool.acceleration) ** 0.5,
            (trial.acceleration * line.angle / tool.angular_acceleration) ** 0.5,
            (trial.jerk * line.length / tool.jerk) ** (1 / 3),
            (trial.jerk * line.angle / tool.angular_jerk) ** (1 / 3),
        )
        used = max(velocity, acceleration**0.5, jerk ** (1 / 3), tool_use)
        if used <= 1.0:
            best = max(best, scale)
            if used >= 0.99:
                break
        scale *= 0.998 / used
    return bounds.scaled(best)
