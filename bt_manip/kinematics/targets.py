"""Targets of inverse kinematics: positions, rotations and poses of frames."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import shown
from bt_manip.robots import (
    check_number,
    check_pose,
    check_positive,
    check_rotation,
    check_vector,
    invalid,
)
from bt_manip.spatial import as_numbers

AXES = dict(zip("xyz", np.eye(3), strict=True))
"""The axes of a frame, by name."""

TOLERANCE = 1e-6  # [m] and [rad] desired error of a constraint without a tolerance


@dataclass(frozen=True, eq=False)
class Target:
    """A constraint or a cost of a frame's error.

    Arguments are checked and copied; invalid ones raise `MotionError`.

    Attributes:
        frame: Name of the frame: a body or a site of the robot.
        weight: Makes the target a cost, weight times half the squared error [1/m2] and [1/rad2].
        tolerance: Makes it a constraint, the largest error [m] and [rad]; for a pose optionally a
            pair. With neither, it is a constraint with the desired error `TOLERANCE`, and the
            `tolerance` of the arm's model is accepted.
    """

    frame: str
    weight: float | None = field(default=None, kw_only=True)
    tolerance: float | tuple[float, float] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check frame, weight and tolerance."""
        if not isinstance(self.frame, str):
            raise invalid(f"frame of a target must be a name, got {shown(self.frame)}")
        if self.weight is not None and self.tolerance is not None:
            raise invalid(
                f"{self.label} must be a cost with a weight or a constraint with a tolerance, "
                f"got weight {self.weight!r} and tolerance {self.tolerance!r}"
            )
        if self.weight is not None:
            self._keep("weight", check_positive(self.weight, f"{self.label}: weight"))
        if self.tolerance is not None:
            self._keep("tolerance", self._check_tolerance())

    @property
    def label(self) -> str:
        """Name of the target in error messages."""
        return f"target of frame '{self.frame}'"

    @property
    def tolerances(self) -> tuple[float, float]:
        """Desired errors of position [m] and rotation [rad] of a constraint."""
        if isinstance(self.tolerance, tuple):
            return self.tolerance
        both = TOLERANCE if self.tolerance is None else self.tolerance
        return both, both

    def _check_tolerance(self) -> float | tuple[float, float]:
        if isinstance(self.tolerance, float) and 0.0 < self.tolerance < np.inf:
            return float(self.tolerance)
        numbers, pair_allowed = as_numbers(self.tolerance), isinstance(self, PoseTarget)
        positive = (np.isfinite(numbers) & (numbers > 0.0)).all()
        if positive and numbers.shape == ():
            return float(numbers)
        if positive and numbers.shape == (2,) and pair_allowed:
            return float(numbers[0]), float(numbers[1])
        pair = ", or a pair of position and rotation [m, rad]" if pair_allowed else ""
        raise invalid(f"{self.label}: tolerance must be above 0{pair}, got {shown(self.tolerance)}")

    def _keep(self, name: str, value: Any) -> None:
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
        object.__setattr__(self, name, value)


@dataclass(frozen=True, eq=False)
class PositionTarget(Target):
    """The origin of a frame at a position.

    Attributes:
        position: Position in the world [m].  # (3,)
    """

    position: np.ndarray

    def __post_init__(self) -> None:
        """Check and copy the position."""
        super().__post_init__()
        self._keep("position", check_vector(self.position, f"{self.label}: position", "m"))


@dataclass(frozen=True, eq=False)
class FreeAxisTarget(Target):
    """A target whose rotation may be free about an axis of the frame.

    Attributes:
        free_axis: Axis of the frame, `"x"`, `"y"`, `"z"` or a vector in the frame, about which the
            rotation is free; None fixes the rotation. It is stored as a unit vector.  # (3,)
        cone: Half angle of the cone around the axis' direction within which the axis may tilt
            [rad]; pi makes its direction free, too.
    """

    free_axis: str | Sequence[float] | np.ndarray | None = field(default=None, kw_only=True)
    cone: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        """Check and store the axis and the cone."""
        super().__post_init__()
        cone = check_number(self.cone, f"{self.label}: cone", "rad")
        if not 0.0 <= cone <= np.pi:
            raise invalid(f"{self.label}: cone must be from 0 to pi [rad], got {self.cone!r}")
        if cone and (self.free_axis is None or self.weight is not None):
            raise invalid(f"{self.label}: a cone needs a free_axis, and no weight")
        self._keep("cone", cone)
        if self.free_axis is None:
            return
        if isinstance(self.free_axis, str):
            if self.free_axis not in AXES:
                raise invalid(
                    f"{self.label}: free_axis must be 'x', 'y', 'z' or a vector, "
                    f"got {self.free_axis!r}"
                )
            axis = AXES[self.free_axis]
        else:
            axis = check_vector(self.free_axis, f"{self.label}: free_axis")
        length = float(np.linalg.norm(axis))
        if not length > 0.0:
            raise invalid(f"{self.label}: free_axis must not be zero")
        self._keep("free_axis", axis / length)

    @property
    def tolerances(self) -> tuple[float, float]:
        """Desired errors of position [m] and rotation, including the cone [rad]."""
        position, rotation = super().tolerances
        return position, max(rotation, self.cone)


@dataclass(frozen=True, eq=False)
class RotationTarget(FreeAxisTarget):
    """The axes of a frame at a rotation.

    Attributes:
        rotation: The frame's axes in the world, as columns.  # (3, 3)
    """

    rotation: np.ndarray

    def __post_init__(self) -> None:
        """Check and copy the rotation."""
        super().__post_init__()
        self._keep("rotation", check_rotation(self.rotation, f"{self.label}: rotation"))


@dataclass(frozen=True, eq=False)
class PoseTarget(FreeAxisTarget):
    """A frame at a pose.

    Attributes:
        pose: The pose T_wf in the world.
        pivot: Point of the frame on the free axis [m].  # (3,)
    """

    pose: pin.SE3
    pivot: Sequence[float] | np.ndarray = field(default=(0.0, 0.0, 0.0), kw_only=True)

    def __post_init__(self) -> None:
        """Check and copy the pose and the pivot."""
        super().__post_init__()
        self._keep("pose", check_pose(self.pose, f"{self.label}: pose").copy())
        pivot = check_vector(self.pivot, f"{self.label}: pivot", "m")
        if pivot.any() and self.free_axis is None:
            raise invalid(f"{self.label}: a pivot needs a free_axis")
        self._keep("pivot", pivot)
