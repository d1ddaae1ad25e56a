"""Random motions of every kind, to be stopped or disturbed."""

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import MotionError
from tests.measuring.scenes import Planned

KINDS = ("planned", "segment", "line", "redirected", "scaled")
STEP = 1e-3  # [s]
_TRIES = 50


def begin(planned: Planned, kind: str, start: np.ndarray, goal: np.ndarray, seed: int) -> None:
    """Start a motion from rest; redirections and changes of the speed scale have been made then.

    Args:
        planned: The arm among obstacles.
        kind: ``planned`` is a collision-free motion to the goal, ``segment`` one to a random
            configuration nearby, as is ``planned`` where the goal is unreachable; ``line`` moves
            the tool on a straight line, ``redirected`` replaces a motion by another one and
            ``scaled`` changes its speed scale.
        start: The start [rad].  # (nq,)
        goal: The goal of ``planned`` [rad].  # (nq,)
        seed: Seed of everything random.
    """
    arm, rng = planned.arm, np.random.default_rng(seed)
    for tried in range(_TRIES):
        far = 1.0 - tried / _TRIES  # motions become shorter where few are free
        arm.reset(start)
        try:
            if kind == "planned" and not tried:
                arm.move_to_configuration(goal, rng=rng)
            elif kind == "line":
                arm.move_linear(_beside(arm.model.pose(start), rng, far))
            else:
                arm.move_to_configuration(_near(planned, start, rng, far), rng=rng)
            if not arm.moving:
                continue
            if kind in ("redirected", "scaled"):
                advance(planned, rng.uniform(0.1, 0.6))
            if kind == "redirected":
                arm.move_to_configuration(_near(planned, start, rng, far), rng=rng)
            elif kind == "scaled":
                arm.speed_scale = float(rng.uniform(0.2, 0.9))
        except MotionError:
            continue
        return
    raise RuntimeError(f"no motion of kind '{kind}' was found in {_TRIES} tries")


def advance(planned: Planned, fraction: float) -> None:
    """Advance the reference by a fraction of its remaining time."""
    for _ in range(int(fraction * planned.arm.remaining / STEP)):
        planned.arm.advance(STEP)


def _near(planned: Planned, q: np.ndarray, rng: np.random.Generator, far: float) -> np.ndarray:
    limits = planned.arm.model.limits
    return np.clip(q + 1.2 * far * rng.uniform(-1.0, 1.0, len(q)), limits.lower, limits.upper)


def _beside(T_wt: pin.SE3, rng: np.random.Generator, far: float) -> pin.SE3:
    turned = T_wt.rotation @ pin.exp3(0.4 * far * rng.uniform(-1.0, 1.0, 3))
    return pin.SE3(turned, T_wt.translation + 0.35 * far * rng.uniform(-1.0, 1.0, 3))
