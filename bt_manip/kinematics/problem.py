"""Inverse kinematics problems and their results."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.collision import PADDING, CollisionWorld
from bt_manip.exceptions import shown
from bt_manip.robots import check_non_negative, check_pose, check_positive, invalid

from .targets import PoseTarget, PositionTarget, RotationTarget, Target

POSTURE_WEIGHT = 1e-2  # [1/s2]


@dataclass(frozen=True, eq=False, kw_only=True)
class IKProblem:
    """Constraints on a configuration, and a cost to minimize in the remaining freedom.

    Targets with a tolerance are constraints. The cost is the sum of the costs of targets with a
    weight, `posture` and `manipulability`. Invalid arguments raise `MotionError`.

    Attributes:
        targets: Any number of targets of frames.
        joints: Names of the joints that may move, by default all; others keep their initial
            positions.
        base: Pose T_wb of the robot's base in the targets' world; by default its pose in the model.
        margin: Distance from the position limits [rad], for all joints or for each.
        posture: Preferred configuration [rad].  # (nq,)
        posture_weight: Weight of half the squared distance from `posture` [1/s2], as measured by
            `InverseKinematics.distance`.
        manipulability: Weight of the negative logarithm of the tool's manipulability.
        world: Collision world of solutions; by default collisions are not checked.
        clearance: Minimum distance of solutions from obstacles [m], up to 8 mm.
    """

    targets: Sequence[Target] = ()
    joints: Sequence[str] | None = None
    base: pin.SE3 | None = None
    margin: float | Sequence[float] | np.ndarray = 0.0
    posture: Sequence[float] | np.ndarray | None = None
    posture_weight: float = POSTURE_WEIGHT
    manipulability: float = 0.0
    world: CollisionWorld | None = None
    clearance: float = 0.0

    def __post_init__(self) -> None:
        """Check the arguments that do not depend on the arm."""
        for name, value in (
            ("targets", _check_targets(self.targets)),
            ("joints", None if self.joints is None else _check_names(self.joints)),
            ("posture_weight", check_positive(self.posture_weight, "posture_weight")),
            ("manipulability", check_non_negative(self.manipulability, "manipulability")),
            ("clearance", check_non_negative(self.clearance, "clearance", "m")),
        ):
            object.__setattr__(self, name, value)
        if not self.targets and self.posture is None and not self.manipulability:
            raise invalid("the problem is empty: it has no targets, posture or manipulability")
        if self.base is not None:
            check_pose(self.base, "base")
        if self.world is None:
            if self.clearance:
                raise invalid(
                    f"a clearance of {self.clearance:g} m needs a CollisionWorld, got world=None"
                )
            return
        if not isinstance(self.world, CollisionWorld):
            raise invalid(f"world must be a CollisionWorld, got {type(self.world).__name__}")
        if self.clearance > PADDING:
            raise invalid(
                f"clearance must be at most {PADDING:g} m, as far as a CollisionWorld measures, "
                f"got {self.clearance:g}"
            )
        if self.base is not None:
            raise invalid(
                "a problem must not have both a base and a CollisionWorld: collisions are checked "
                "with the base's pose in the model only"
            )


def _check_targets(given: Any) -> tuple[Target, ...]:
    """Return one target or several as a tuple."""
    targets = tuple(given) if _is_iterable(given) else (given,)
    for target in targets:
        if not isinstance(target, PositionTarget | RotationTarget | PoseTarget):
            raise invalid(
                "a target must be a PositionTarget, RotationTarget or PoseTarget, "
                f"got {type(target).__name__}"
            )
    return targets


def _check_names(given: Any) -> tuple[str, ...]:
    names = tuple(given) if _is_iterable(given) and not isinstance(given, str) else (given,)
    if isinstance(given, str) or not all(isinstance(name, str) for name in names):
        found = list(names) if _is_iterable(given) and not isinstance(given, str) else given
        raise invalid(f"joints must be a list of names, got {shown(found)}")
    return names


def _is_iterable(value: Any) -> bool:
    # Zero-dimensional arrays have __iter__, too.
    return isinstance(value, Iterable) and getattr(value, "ndim", 1) > 0


class Residual(NamedTuple):
    """Error of a frame from its target.

    Attributes:
        frame: Name of the frame.
        position: Distance [m], 0 for a rotation.
        rotation: Angle [rad], 0 for a position.
        met: Whether both are within the tolerances; true for a cost.
    """

    frame: str
    position: float
    rotation: float
    met: bool


class IKResult(NamedTuple):
    """A solution, or the configuration with the smallest residual.

    Attributes:
        q: The configuration, inside the limits.  # (nq,)
        solved: Whether all constraints are met.
        residuals: Residual of each target, in the order of the request.
        iterations: Total number of iterations.
        restarts: Number of initial guesses after the first.
        reason: Why it is not solved; empty for a solution.
        target: Index of its pose among several alternatives.
        cost: Sum of the problem's costs; 0 without any.
    """

    q: np.ndarray
    solved: bool
    residuals: tuple[Residual, ...]
    iterations: int
    restarts: int = 0
    reason: str = ""
    target: int = 0
    cost: float = 0.0

    @property
    def position_error(self) -> float:
        """Largest distance of a frame from its target [m]."""
        return max(residual.position for residual in self.residuals)

    @property
    def rotation_error(self) -> float:
        """Largest angle between a frame and its target [rad]."""
        return max(residual.rotation for residual in self.residuals)
