"""Where something may be put."""

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from bt_manip.cell.exceptions import CellError
from bt_manip.spatial import pose

Range = tuple[float, float]


@dataclass(frozen=True)
class Region:
    """Poses in a box, turned about the vertical.

    Attributes:
        x: Lowest and highest in the world [m].
        y: Lowest and highest in the world [m].
        z: Lowest and highest in the world [m].
        yaw: Least and greatest turn about the vertical [rad].
        middle: What of the thing comes to lie there, x and y in its own frame; its origin unless
            told otherwise [m].
    """

    x: Range
    y: Range
    z: Range
    yaw: Range = (-math.pi, math.pi)
    middle: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse what is no range.

        Raises:
            CellError: When a bound is missing, not finite, or the lowest is above the highest.
        """
        for name in ("x", "y", "z", "yaw"):
            bounds = getattr(self, name)
            if len(bounds) != 2 or not all(map(math.isfinite, bounds)) or bounds[0] > bounds[1]:
                raise CellError(f"a region's {name} goes from low to high, got {bounds}")

    def sample(self, rng: np.random.Generator) -> pin.SE3:
        """Draw a pose; a range of one value draws nothing."""
        x, y, z, yaw = (
            low if low == high else rng.uniform(low, high)
            for low, high in (self.x, self.y, self.z, self.yaw)
        )
        if any(self.middle):
            c, s = math.cos(yaw), math.sin(yaw)
            x -= c * self.middle[0] - s * self.middle[1]
            y -= s * self.middle[0] + c * self.middle[1]
        return pose((x, y, z), (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))

    def covers(self, T_wo: pin.SE3, slack: float = 1e-3) -> bool:
        """Tell whether a thing's middle is over, under or inside the region [m]."""
        position = T_wo.act(np.array([*self.middle, 0.0]))
        return all(
            low - slack <= value <= high + slack
            for value, (low, high) in zip(position[:2], (self.x, self.y), strict=True)
        )
