"""Set down what the gripper holds."""

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input, Status
from bt_manip.cell import CellError
from bt_manip.grasping import GripperClearance, with_clearance

from .extent import extent
from .letting_go import LettingGoBehaviour
from .poses import nearest_orientation, pose_input, yaw_of

_QUARTER_TURN = math.pi / 2
OVER, DOWN = "over", "down"


class PlacingBehaviour(LettingGoBehaviour):
    """Carry what is held over a place, lower it straight down, and let it go.

    Of the quarter turns by which it can be set down one is taken at which the gripper has the
    clearance to open; of those the one with the nearest configuration.
    """

    object = Input(str, doc="Name of the object that is held.")
    height = Input(float, default=0.1, doc="How far over the place it comes down from [m].")
    gap = Input(float, default=1e-3, doc="How far over the place it is let go [m].")
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    memory = (*LettingGoBehaviour.memory, "_phase")

    _phase = OVER

    def start(self) -> None:
        """Move over the place."""
        self._phase = OVER
        if self.object not in self.gripper.held:
            held = ", ".join(self.gripper.held) or "nothing"
            self.fail(f"the gripper holds {held}, not '{self.object}'")
            return
        clearance = GripperClearance(self.cell, self.arm.robot, self.ignored())
        grips, _ = with_clearance(self._grips(), clearance)
        up = np.array([0.0, 0.0, self.height])
        poses = [pin.SE3(T.rotation, T.translation + up) for T in grips]
        self.arm.move_to_pose(poses, speed=self.speed, approach=self.height)

    def place(self) -> tuple[np.ndarray, float]:
        """Say where the middle of the object's bottom shall come to be, and its yaw [m, rad].

        Raises:
            CellError: When there is no such place.
        """
        raise NotImplementedError

    def ignored(self) -> Sequence[str]:
        """Name what the gripper may come near to when it lets go."""
        return [self.object]

    def arrived(self) -> Status:
        """Go on: from over the place down to it, and then open."""
        if self._phase == DOWN:
            return self.let_go()
        if self.object not in self.gripper.held:
            return self.fail(f"'{self.object}' was lost on the way")
        self._phase, self._ended = DOWN, None
        self.feedback_message = "going down"
        return self.begin_motion(self._lower)

    def begin_again(self) -> Status:
        """Ask once more for the motion that another robot was in the way of."""
        return self.begin_motion(self._lower if self._phase == DOWN else self.start)

    def _lower(self) -> None:
        self.arm.move_linear(nearest_orientation(self._grips(), self.T_wt), speed=self.speed)

    def _grips(self) -> list[pin.SE3]:
        """List the tool poses at which the object, held as it is, is where it shall be let go.

        One for each quarter turn.
        """
        cell = self.cell
        bottom, yaw = self.place()
        T_wo = cell.pose(self.object)
        lower, upper = extent(cell, self.object)
        middle = 0.5 * (lower + upper)
        below = np.array([middle[0], middle[1], lower[2]])
        T_wt = self.T_wt
        found = []
        for quarter in range(4):
            turn = pin.utils.rotate("z", yaw - yaw_of(T_wo) + quarter * _QUARTER_TURN)
            T = pin.SE3(turn, bottom + np.array([0.0, 0.0, self.gap]) - turn @ below)
            found.append(T * T_wt)
        return found


class PlaceOn(PlacingBehaviour):
    """Set what the gripper holds down on the middle of another object, and let it go."""

    support = Input(str, doc="Name of the object to set it down on.")

    def place(self) -> tuple[np.ndarray, float]:
        """Give the middle of the other's top, and how that one is turned."""
        if self.support == self.object:
            raise CellError(f"'{self.object}' cannot be set down on itself")
        lower, upper = extent(self.cell, self.support)
        middle = 0.5 * (lower + upper)
        top = np.array([middle[0], middle[1], upper[2]])
        return top, yaw_of(self.cell.pose(self.support))


class PlaceAt(PlacingBehaviour):
    """Set what the gripper holds down at a pose, and let it go."""

    pose = pose_input("Where the middle of its bottom comes to be: x;y;z;qw;qx;qy;qz [m].")

    def place(self) -> tuple[np.ndarray, float]:
        """Give the pose's position and its yaw."""
        return self.pose.translation, yaw_of(self.pose)
