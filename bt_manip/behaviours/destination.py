"""Where an object belongs, for the progress towards a goal."""

from typing import NamedTuple, Self

import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell, extent, geom_boxes


class Destination(NamedTuple):
    """Boxes for the middle of an object's bottom, which it enters from above.

    Attributes:
        T_wd: Frame of the boxes in the world, upright.
        lower: Lower corners; the object rests at this height [m].  # (n, 3)
        upper: Upper corners; beside the box, the object has to be higher [m].  # (n, 3)
        walls: Whether the sides of the boxes are walls, from which the object is half its width
            away.
    """

    T_wd: pin.SE3
    lower: np.ndarray
    upper: np.ndarray
    walls: bool = False

    @classmethod
    def inside(cls, cell: Cell, container: str) -> Self:
        """Return the inside of a container."""
        T_wd = cell.pose(container)
        lower, upper = extent(cell, container, T_wd)
        return cls(T_wd, lower[None], upper[None], walls=True)

    @classmethod
    def on(cls, cell: Cell, support: str) -> Self:
        """Return the tops of the parts of a support, such as the boards of a shelf."""
        T_wd = cell.pose(support)
        lower, upper = geom_boxes(cell, support, T_wd)
        lower[:, 2] = upper[:, 2]
        return cls(T_wd, lower, upper)
