"""Trajectories that the motors can drive."""

from collections.abc import Callable
from typing import TypeVar

from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotModel

from .limit_check import effort_use
from .trajectory import Trajectory

ALLOWED = 0.95  # of every effort limit
TRIES = 14
_BACK = 0.7  # factor of the first tries
_NEAR = 0.97  # good and bad factor nearer than this end the search

AnyTrajectory = TypeVar("AnyTrajectory", bound=Trajectory)


def scale_to_effort_limits(
    make: Callable[[float], AnyTrajectory], model: RobotModel, *, allowed: float = ALLOWED
) -> AnyTrajectory:
    """Slow a trajectory until inverse dynamics asks no more than is allowed.

    Args:
        make: Plans with accelerations and jerks scaled by a factor from 0 to 1.
        model: The arm with its payload.
        allowed: Fraction of every effort limit.

    Raises:
        MotionError: When even standing still on the way asks for more.
    """
    best: AnyTrajectory | None = None
    good, bad, factor = 0.0, 1.0, 1.0
    asked = 0.0
    for _ in range(TRIES):
        trajectory = make(factor)
        asked = effort_use(trajectory, model)
        if asked <= allowed:
            best, good = trajectory, factor
        else:
            bad = factor
        if good == 1.0 or good >= _NEAR * bad:
            break
        factor = _BACK * bad if best is None else 0.5 * (good + bad)
    if best is None:
        raise MotionError(
            f"the motion asks for {100.0 * asked:.0f} % of an effort limit even when slow, "
            f"{100.0 * allowed:.0f} % are allowed",
            reason="effort",
        )
    return best
