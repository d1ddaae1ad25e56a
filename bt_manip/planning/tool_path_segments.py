"""The pieces that paths of the tool are made of."""

from typing import Protocol

import numpy as np
import pinocchio as pin

ARM_LENGTH = 0.3  # [m/rad] how a turn counts as travel


class Segment(Protocol):
    """A piece of a path, along which place and rotation change evenly.

    Attributes:
        length: Way of the tool's origin [m].
        angle: Angle that the tool turns by [rad].
        travel: What both together count as [m]; it is the path's parameter.
        straight: Whether it is a line.
    """

    length: float
    angle: float
    travel: float
    straight: bool

    def pose(self, way: float) -> pin.SE3:
        """Give the pose T_wt after some of the travel, from 0 to all of it."""


class Line:
    """The straight line between two poses, turning evenly about one axis."""

    straight = True

    def __init__(self, start: pin.SE3, end: pin.SE3) -> None:
        """Connect two poses of the tool in the world."""
        self._place, self._rotation = start.translation.copy(), start.rotation.copy()
        self._offset = end.translation - start.translation
        self._turn = pin.log3(start.rotation.T @ end.rotation)
        self.length = float(np.linalg.norm(self._offset))
        self.angle = float(np.linalg.norm(self._turn))
        self.travel = max(self.length, ARM_LENGTH * self.angle)

    def pose(self, way: float) -> pin.SE3:
        """Give the pose after some of the travel."""
        part = way / self.travel
        rotation = self._rotation
        if self.angle:
            rotation = rotation @ pin.exp3(part * self._turn)
        return pin.SE3(rotation, self._place + part * self._offset)


class Arc:
    """A piece of a circle, with the tool turning evenly about one axis of its own."""

    straight = False

    def __init__(
        self,
        start: pin.SE3,
        centre: np.ndarray,
        sweep: np.ndarray,
        turn: np.ndarray,
    ) -> None:
        """Go around a centre.

        Args:
            start: Pose of the tool in the world.
            centre: Of the circle [m], in the plane through the start.  # (3,)
            sweep: Axis of the circle times the angle to go around by [rad].  # (3,)
            turn: Axis times angle of the tool's own turn, seen from the tool [rad].  # (3,)
        """
        self._start, self._centre, self._sweep, self._turn = start, centre, sweep, turn
        self._spoke = start.translation - centre
        around = float(np.linalg.norm(sweep))
        self.length = float(np.linalg.norm(self._spoke)) * around
        self.angle = float(np.linalg.norm(turn))
        self.travel = max(self.length, ARM_LENGTH * self.angle)

    def pose(self, way: float) -> pin.SE3:
        """Give the pose after some of the travel."""
        part = way / self.travel
        place = self._centre + pin.exp3(part * self._sweep) @ self._spoke
        return pin.SE3(self._start.rotation @ pin.exp3(part * self._turn), place)
