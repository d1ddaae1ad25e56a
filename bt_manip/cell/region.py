"""A region of poses."""

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from bt_manip.spatial import pose

from .exceptions import CellError

Range = tuple[float, float]


@dataclass(frozen=True)
class Region:
    """Upright poses in a box, with a range of yaw.

    Attributes:
        x: Bounds in the world [m].
        y: Bounds in the world [m].
        z: Bounds in the world [m].
        yaw: Bounds of the rotation about the vertical [rad].
        middle: Point of the entity that the bounds are for, x and y in its frame [m].
        squares: Centres of squares; positions are sampled from these, not from the whole box
            [m].  # (n, 2)
        side: Length of the squares' sides [m].
    """

    x: Range
    y: Range
    z: Range
    yaw: Range = (-math.pi, math.pi)
    middle: tuple[float, float] = (0.0, 0.0)
    squares: tuple[tuple[float, float], ...] = ()
    side: float = 0.0

    def __post_init__(self) -> None:
        """Check the bounds.

        Raises:
            CellError: If a bound is missing, not finite, or the lower is above the upper.
        """
        for name in ("x", "y", "z", "yaw"):
            bounds = getattr(self, name)
            if len(bounds) != 2 or not all(map(math.isfinite, bounds)) or bounds[0] > bounds[1]:
                raise CellError(f"a region's {name} goes from low to high, got {bounds}")

    def sample(self, rng: np.random.Generator) -> pin.SE3:
        """Sample a pose; equal bounds take no random number."""
        x_range, y_range = self.x, self.y
        if self.squares:
            x, y = self.squares[int(rng.integers(len(self.squares)))]
            half = 0.5 * self.side
            x_range, y_range = (x - half, x + half), (y - half, y + half)
        x, y, z, yaw = (
            low if low == high else rng.uniform(low, high)
            for low, high in (x_range, y_range, self.z, self.yaw)
        )
        if any(self.middle):
            c, s = math.cos(yaw), math.sin(yaw)
            x -= c * self.middle[0] - s * self.middle[1]
            y -= s * self.middle[0] + c * self.middle[1]
        return pose((x, y, z), (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))

    def covers(self, T_wo: pin.SE3, slack: float = 1e-3) -> bool:
        """Tell whether an entity's middle is in the region, whatever its height.

        Args:
            T_wo: Pose of the entity.
            slack: Distance outside that is accepted [m].
        """
        position = T_wo.act(np.array([*self.middle, 0.0]))
        if self.squares:
            apart = np.abs(np.array(self.squares) - position[:2]).max(axis=1)
            return bool(apart.min() <= 0.5 * self.side + slack)
        return all(
            low - slack <= value <= high + slack
            for value, (low, high) in zip(position[:2], (self.x, self.y), strict=True)
        )
