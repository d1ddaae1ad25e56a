"""A region of poses."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pinocchio as pin

from bt_manip.spatial import pose
from bt_manip.toml import Key, documented

from .exceptions import CellError

Range = tuple[float, float]


@documented
@dataclass(frozen=True)
class Region:
    """Upright poses in a box, with a range of yaw.

    Bounds are a minimum and a maximum. In Python, positions can be restricted to `squares`, given
    by their centres [m] (n, 2) and the length of their `side` [m]. The bounds apply to the point
    `middle` of the entity, x and y in its frame [m].
    """

    x: Annotated[Range, Key("Bounds in the world", "m", size=2)]
    y: Annotated[Range, Key("Bounds in the world", "m", size=2)]
    z: Annotated[Range, Key("Bounds in the world; not with `on`", "m", size=2, needed=False)]
    yaw: Annotated[
        Range,
        Key("Bounds of the rotation about the vertical; by default a full turn", "rad", size=2),
    ] = (-math.pi, math.pi)
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
        """Sample a pose; equal bounds use no random number."""
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
        """Return whether the point `middle` of an entity is in the region, at any height.

        Args:
            T_wo: Pose of the entity.
            slack: Accepted distance outside the region [m].
        """
        position = T_wo.act(np.array([*self.middle, 0.0]))
        if self.squares:
            apart = np.abs(np.array(self.squares) - position[:2]).max(axis=1)
            return bool(apart.min() <= 0.5 * self.side + slack)
        return all(
            low - slack <= value <= high + slack
            for value, (low, high) in zip(position[:2], (self.x, self.y), strict=True)
        )
