"""Targets of inverse kinematics: positions, rotations and poses of frames."""

from dataclasses import dataclass, field
from typing import Any

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

TOLERANCE = 1e-6  # [m] and [rad] that a constraint without a tolerance of its own aims at


@dataclass(frozen=True, eq=False)
class Target:
    """A constraint or a cost of a frame's error.

    Arguments are checked and copied; invalid ones raise `MotionError`.

    Attributes:
        frame: Name of the frame: a body or a site of the robot.
        weight: Makes the target a cost: half the squared error times this [1/m2] and [1/rad2].
        tolerance: Makes it a constraint: the largest error [m] and [rad]; for a pose also a pair
            of both. With neither, it is a constraint that aims at `TOLERANCE` and accepts the
            `tolerance` of the arm's model.
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
        """Errors of position [m] and rotation [rad] that a constraint aims at."""
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
        position: In the world [m].  # (3,)
    """

    position: np.ndarray

    def __post_init__(self) -> None:
        """Keep a copy of the position."""
        super().__post_init__()
        self._keep("position", check_vector(self.position, f"{self.label}: position", "m"))


@dataclass(frozen=True, eq=False)
class RotationTarget(Target):
    """The axes of a frame at a rotation.

    Attributes:
        rotation: The frame's axes in the world, as columns.  # (3, 3)
    """

    rotation: np.ndarray

    def __post_init__(self) -> None:
        """Keep a copy of the rotation."""
        super().__post_init__()
        self._keep("rotation", check_rotation(self.rotation, f"{self.label}: rotation"))


@dataclass(frozen=True, eq=False)
class PoseTarget(Target):
    """A frame at a pose.

    Attributes:
        pose: The pose T_wf in the world.
    """

    pose: pin.SE3

    def __post_init__(self) -> None:
        """Keep a copy of the pose."""
        super().__post_init__()
        self._keep("pose", check_pose(self.pose, f"{self.label}: pose").copy())
