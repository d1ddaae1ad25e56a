"""Inverse kinematics as one states it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.checks import check_non_negative, check_pose, check_positive, invalid, shown
from bt_manip.collision import PADDING, CollisionWorld
from bt_manip.exceptions import MotionError

from .targets import PoseTarget, PositionTarget, RotationTarget, Target

POSTURE_WEIGHT = 1e-2  # [1/s2]
_KINDS = (PositionTarget, RotationTarget, PoseTarget)


@dataclass(frozen=True, eq=False, kw_only=True)
class IKProblem:
    """What a configuration has to meet, and what it should be like beside that.

    Targets with a tolerance are constraints. Where they leave freedom, the sum of all costs is
    made least: of the targets with a weight, of `posture` and of `manipulability`.

    Attributes:
        targets: What frames shall do; any number of them, also none.
        joints: Names of the joints that may move, by default all; the others stay where the
            search starts.
        base: Pose T_wb of the robot's base in the world that targets are given in; by default
            where it stands.
        margin: How far to stay from the limits [rad], for all joints or for each.
        posture: A configuration to be near to [rad].  # (nq,)
        posture_weight: What half the squared distance from it costs [1/s2]; distances are those of
            `InverseKinematics.distance`.
        manipulability: What a unit less of the logarithm of the tool's manipulability costs.
        free: What the arm shall not touch; by default it does not look.
        clearance: How far from that it shall be [m], up to what a `CollisionWorld` sees, 8 mm.
    """

    targets: Sequence[Target] = ()
    joints: Sequence[str] | None = None
    base: pin.SE3 | None = None
    margin: float | Sequence[float] | np.ndarray = 0.0
    posture: Sequence[float] | np.ndarray | None = None
    posture_weight: float = POSTURE_WEIGHT
    manipulability: float = 0.0
    free: CollisionWorld | None = None
    clearance: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what can be seen to be wrong without the arm.

        Raises:
            MotionError: Naming what is wrong.
        """
        keep = partial(object.__setattr__, self)
        keep("targets", _targets(self.targets))
        keep("posture_weight", check_positive(self.posture_weight, "posture_weight"))
        keep("manipulability", check_non_negative(self.manipulability, "manipulability"))
        keep("clearance", check_non_negative(self.clearance, "clearance", "m"))
        if not self.targets and self.posture is None and not self.manipulability:
            raise invalid(
                "the problem is empty: it has no targets, no posture and no manipulability"
            )
        if self.joints is not None:
            keep("joints", _names(self.joints))
        self._check_free()
        if self.base is not None:
            try:
                check_pose(self.base)
            except MotionError as error:
                raise invalid(f"base: {error}") from None

    def _check_free(self) -> None:
        """Refuse what nothing can be kept free of, and clearances that nobody looks for."""
        free, clearance = self.free, self.clearance
        if free is None:
            if clearance:
                raise invalid(
                    f"a clearance of {clearance:g} m needs a CollisionWorld, got free=None"
                )
            return
        if not isinstance(free, CollisionWorld):
            raise invalid(f"free must be a CollisionWorld, got {type(free).__name__}")
        if clearance > PADDING:
            raise invalid(
                f"clearance must be at most {PADDING:g} m, which is as far as a CollisionWorld "
                f"measures, got {clearance:g}"
            )
        if self.base is not None:
            raise invalid(
                "a problem must not have both a base and a CollisionWorld: collisions "
                "are known only where the base stands"
            )


def _targets(given: Any) -> tuple[Target, ...]:
    """Give one target or several as a tuple."""
    several = not isinstance(given, Target) and _is_many(given)
    targets = tuple(given) if several else (given,)
    for target in targets:
        if not isinstance(target, _KINDS):
            raise invalid(
                "a target must be a PositionTarget, RotationTarget or PoseTarget, "
                f"got {type(target).__name__}"
            )
    return targets


def _names(given: Any) -> tuple[str, ...]:
    """Give names of joints as a tuple; a lone text is no list of them."""
    several = not isinstance(given, str) and _is_many(given)
    names = tuple(given) if several else ()
    if not several or not all(isinstance(name, str) for name in names):
        found = shown(list(names) if several else given)
        raise invalid(f"joints must be a list of names, got {found}")
    return names


def _is_many(given: Any) -> bool:
    # Arrays without a dimension say that they can be iterated over.
    return isinstance(given, Iterable) and getattr(given, "ndim", 1) > 0
