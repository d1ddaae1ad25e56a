"""What frames of an arm shall do: be at a position, turned some way, or both."""

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from bt_manip.checks import (
    as_numbers,
    check_pose,
    check_positive,
    check_rotation,
    check_vector,
    invalid,
    shown,
)
from bt_manip.exceptions import MotionError

TOLERANCE = 1e-6  # [m] and [rad] of a constraint that says nothing else


@dataclass(frozen=True, eq=False)
class Target:
    """What a frame shall do, as a cost or as a constraint.

    Attributes:
        frame: Name of the frame: a body or a site of the robot.
        weight: Makes it a cost, of half this times the squared error [1/m2] and [1/rad2].
        tolerance: Makes it a constraint: the largest error [m] and [rad]; for a pose also a pair
            of both. Without a weight either, it is a constraint with `TOLERANCE`.
    """

    frame: str
    weight: float | None = field(default=None, kw_only=True)
    tolerance: float | tuple[float, float] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Refuse what is neither a cost nor a constraint, or both.

        Raises:
            MotionError: Naming the frame, and what was found.
        """
        if not isinstance(self.frame, str):
            raise invalid(f"frame of a target must be a name, got {shown(self.frame)}")
        if self.weight is not None and self.tolerance is not None:
            raise invalid(
                f"{self.label} must be a cost with a weight or a constraint with a tolerance, "
                f"got weight {self.weight!r} and tolerance {self.tolerance!r}"
            )
        if self.weight is not None:
            check_positive(self.weight, f"{self.label}: weight")
        if self.tolerance is not None:
            object.__setattr__(self, "tolerance", self._checked_tolerance())

    @property
    def label(self) -> str:
        """How errors call it."""
        return f"target of frame '{self.frame}'"

    @property
    def tolerances(self) -> tuple[float, float]:
        """Largest errors of position [m] and rotation [rad] as a constraint."""
        if isinstance(self.tolerance, tuple):
            return self.tolerance
        both = TOLERANCE if self.tolerance is None else self.tolerance
        return both, both

    def _checked_tolerance(self) -> float | tuple[float, float]:
        numbers = as_numbers(self.tolerance)
        is_pose = isinstance(self, PoseTarget)
        if (
            numbers.shape not in ((), (2,))[: 1 + is_pose]
            or not (np.isfinite(numbers) & (numbers > 0.0)).all()
        ):
            also = ", or a pair of position and rotation [m, rad]" if is_pose else ""
            raise invalid(
                f"{self.label}: tolerance must be above 0{also}, got {shown(self.tolerance)}"
            )
        return float(numbers) if numbers.ndim == 0 else (float(numbers[0]), float(numbers[1]))


@dataclass(frozen=True, eq=False)
class PositionTarget(Target):
    """The origin of a frame at a place.

    Attributes:
        position: Where in the world [m].  # (3,)
    """

    position: np.ndarray

    def __post_init__(self) -> None:
        """Keep a copy, if it is a position.

        Raises:
            MotionError: When it is none.
        """
        super().__post_init__()
        _keep(self, "position", check_vector(self.position, f"{self.label}: position", "m"))


@dataclass(frozen=True, eq=False)
class RotationTarget(Target):
    """The axes of a frame turned some way.

    Attributes:
        rotation: The frame's axes in the world, as columns.  # (3, 3)
    """

    rotation: np.ndarray

    def __post_init__(self) -> None:
        """Keep a copy, if it is a rotation.

        Raises:
            MotionError: When it is none.
        """
        super().__post_init__()
        try:
            _keep(self, "rotation", check_rotation(self.rotation))
        except MotionError as error:
            raise invalid(f"{self.label}: {error}") from None


@dataclass(frozen=True, eq=False)
class PoseTarget(Target):
    """A frame at a pose.

    Attributes:
        pose: The pose T_wf in the world.
    """

    pose: pin.SE3

    def __post_init__(self) -> None:
        """Keep a copy, if it is a pose.

        Raises:
            MotionError: When it is none.
        """
        super().__post_init__()
        try:
            object.__setattr__(self, "pose", check_pose(self.pose).copy())
        except MotionError as error:
            raise invalid(f"{self.label}: {error}") from None


def _keep(target: Target, name: str, array: np.ndarray) -> None:
    array.setflags(write=False)
    object.__setattr__(target, name, array)
