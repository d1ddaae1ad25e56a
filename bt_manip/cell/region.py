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

    Bounds are a lowest and a highest value. In Python, a region may consist of `squares`, by their
    centres [m] (n, 2) and the length of their `side` [m]; positions are sampled from these, not
    from the whole box. `middle` is the point of the entity that the bounds are for, x and y in its
    frame [m].
    """

    x: Annotated[Range, Key("Bounds in the world", "m", size=2)]
    y: Annotated[Range, Key("Bounds in the world", "m", size=2)]
    z: Annotated[Range, Key("Bounds in the world; not with `on`", "m", size=2, needed=False)]
    yaw: Annotated[
        Range, Key("Bounds of the rotation about the vertical; by default any", "rad", size=2)
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
