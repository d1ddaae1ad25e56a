"""Motions of every kind that an arm makes, asked for at random, for those who halt or push it."""

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import MotionError
from tests.measuring.scenes import Planned

KINDS = ("way", "joints", "line", "redirected", "paced")
STEP = 1e-3  # [s]
_TRIES = 50


def begin(planned: Planned, kind: str, start: np.ndarray, goal: np.ndarray, seed: int) -> None:
    """Begin a motion from rest; those that are redirected or paced are so when this returns.

    Args:
        planned: The arm among obstacles.
        kind: ``way`` goes around what is in the way, ``joints`` somewhere near, as does ``way``
            where there is none; ``line`` moves the tool on a straight line, ``redirected`` and
            ``paced`` change another one on its way.
        start: Where from [rad].  # (nq,)
        goal: Where the way goes [rad].  # (nq,)
        seed: Of all that is random.
    """
    arm, rng = planned.arm, np.random.default_rng(seed)
    for tried in range(_TRIES):
        far = 1.0 - tried / _TRIES  # where there is little room, motions are shorter
        arm.reset(start)
        try:
            if kind == "way" and not tried:
                arm.move_to_configuration(goal, rng=rng)
            elif kind == "line":
                arm.move_linear(_beside(arm.model.pose(start), rng, far))
            else:
                arm.move_to_configuration(_near(planned, start, rng, far), rng=rng)
            if not arm.moving:
                continue
            if kind in ("redirected", "paced"):
                advance(planned, rng.uniform(0.1, 0.6))
            if kind == "redirected":
                arm.move_to_configuration(_near(planned, start, rng, far), rng=rng)
            elif kind == "paced":
                arm.speed_scale = float(rng.uniform(0.2, 0.9))
        except MotionError:
            continue
        return
    raise RuntimeError(f"no motion of the kind '{kind}' was found in {_TRIES} tries")


def advance(planned: Planned, share: float) -> None:
    """Move the reference on by a share of what is left of its motion."""
    for _ in range(int(share * planned.arm.remaining / STEP)):
        planned.arm.advance(STEP)


def _near(planned: Planned, q: np.ndarray, rng: np.random.Generator, far: float) -> np.ndarray:
    limits = planned.arm.model.limits
    return np.clip(q + 1.2 * far * rng.uniform(-1.0, 1.0, len(q)), limits.lower, limits.upper)


def _beside(T_wt: pin.SE3, rng: np.random.Generator, far: float) -> pin.SE3:
    turned = T_wt.rotation @ pin.exp3(0.4 * far * rng.uniform(-1.0, 1.0, 3))
    return pin.SE3(turned, T_wt.translation + 0.35 * far * rng.uniform(-1.0, 1.0, 3))
