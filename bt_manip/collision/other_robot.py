"""Another robot, as an arm that plans its motions sees it."""

from typing import NamedTuple, Protocol

import numpy as np

from .robot_geometry import RobotGeometry


class Comes(Protocol):
    """What comes to rest somewhere."""

    @property
    def target(self) -> np.ndarray:
        """Configuration that it will come to rest at [rad]."""  # (nq,)


class OtherRobot(NamedTuple):
    """A robot that others plan around.

    Attributes:
        name: Its name in the cell.
        figure: Its bodies, with what it holds.
        arm: Tells where it will come to rest.
    """

    name: str
    figure: RobotGeometry
    arm: Comes
