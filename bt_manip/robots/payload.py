"""The payload of a robot."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from .errors import RobotError


@dataclass(frozen=True, eq=False)
class Payload:
    """A rigid body held at the tool.

    Attributes:
        mass: Mass [kg].
        com: Centre of mass in the tool frame [m].  # (3,)
        inertia: Tensor about the centre of mass, in axes of the tool frame [kg m2].  # (3, 3)
    """

    mass: float
    com: np.ndarray = field(default_factory=lambda: np.zeros(3))
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))

    def __post_init__(self) -> None:
        """Copy, check and freeze the arrays."""
        for name, shape in (("com", (3,)), ("inertia", (3, 3))):
            array = np.array(getattr(self, name), dtype=float)
            if array.shape != shape or not np.isfinite(array).all():
                raise RobotError(f"a payload's {name} is {shape} finite numbers, got {array}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if not (np.isfinite(self.mass) and self.mass >= 0.0):
            raise RobotError(f"a payload's mass is not negative, got {self.mass} kg")
        object.__setattr__(self, "mass", float(self.mass))

    @property
    def spatial_inertia(self) -> pin.Inertia:
        """The payload as a spatial inertia in the tool frame."""
        return pin.Inertia(self.mass, self.com.copy(), self.inertia.copy())

    def get_state(self) -> dict[str, Any]:
        """Return the payload as plain data."""
        return {"mass": self.mass, "com": self.com.tolist(), "inertia": self.inertia.tolist()}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> "Payload":
        """Return a payload from plain data."""
        return cls(state["mass"], np.array(state["com"]), np.array(state["inertia"]))
