"""What the joints of an arm can do."""

from dataclasses import dataclass, fields

import numpy as np

from .errors import RobotError


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Bounds of every joint of an arm; the arrays are read-only copies.

    Attributes:
        lower: Least position [rad] or [m], minus infinity where there is none.  # (nq,)
        upper: Greatest position.  # (nq,)
        velocity: Greatest speed [rad/s].  # (nq,)
        acceleration: Greatest acceleration [rad/s2].  # (nq,)
        jerk: Greatest jerk [rad/s3].  # (nq,)
        effort: Greatest torque [N m] or force [N].  # (nq,)
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    effort: np.ndarray

    def __post_init__(self) -> None:
        """Copy, check and freeze the arrays."""
        for field in fields(self):
            array = np.array(getattr(self, field.name), dtype=float)
            array.setflags(write=False)
            object.__setattr__(self, field.name, array)
        for field in fields(self):
            array = getattr(self, field.name)
            if array.shape != self.lower.shape or array.ndim != 1:
                raise RobotError(
                    f"joint limits: one {field.name} a joint, {self.lower.shape} of them, "
                    f"got shape {array.shape}"
                )
            if field.name not in ("lower", "upper") and not (array > 0.0).all():
                raise RobotError(f"joint limits: {field.name} must be positive, got {array}")
        if not (self.lower < self.upper).all():
            raise RobotError(f"joint limits: lower {self.lower} not below upper {self.upper}")

    def contain(self, q: np.ndarray, tolerance: float = 0.0) -> bool:
        """Tell whether a configuration is inside the position limits."""
        return bool((q >= self.lower - tolerance).all() and (q <= self.upper + tolerance).all())
