"""Placing of the held object."""

from collections.abc import Sequence
from itertools import islice

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input, Status
from bt_manip.cell import CellError, extent, why_not_on
from bt_manip.exceptions import MotionError
from bt_manip.grasping import GripperClearance, with_clearance

from .arm_behaviour import speed_input
from .object_port import ObjectInput
from .poses import QUARTER_TURN, nearest_orientation, pose_input, yaw_of
from .releasing import ReleasingBehaviour
from .support import Support, find_support

OVER, DOWN = "over", "down"
_MAX_PLACES = 64  # maximum number of free positions on a support with a planned motion
_LEVEL = 0.03  # [m] tolerance of the height of an object's bottom on its support


class PlacingBehaviour(ReleasingBehaviour):
    """Move the held object over a target, lower it straight down, and release it.

    Of four yaws, a quarter turn apart, at which the gripper has clearance to open, the one with the
    nearest configuration is used. It fails if the object is lost during the motion or does not come
    to rest at its target.
    """

    object = ObjectInput(str, doc="Name of the held object.")
    height = Input(float, default=0.1, doc="Height over the target at first [m].", at_least=0.0)
    gap = Input(float, default=1e-3, doc="Height over it at the release [m].", at_least=0.0)
    speed = speed_input()

    memory = (*ReleasingBehaviour.memory, "_phase")

    _phase = OVER

    def start(self) -> None:
        """Move over the target."""
        self._phase = OVER
        if self.object not in self.gripper.held:
            held = ", ".join(self.gripper.held) or "nothing"
            self.fail(f"the gripper holds {held}, not '{self.object}'")
            return
        self._carried = [self.object]
        self.begin_over()

    def begin_over(self) -> None:
        """Start the motion to a pose over the target."""
        clearance = GripperClearance(self.cell, self.arm.robot, self.ignored())
        grips, _ = with_clearance(self._grips(), clearance)
        up = np.array([0.0, 0.0, self.height])
        poses = [pin.SE3(T.rotation, T.translation + up) for T in grips]
        self.arm.move_to_pose(poses, speed=self.speed, approach=self.height)

    def target(self) -> tuple[np.ndarray, float]:
        """Return the target of the object's bottom centre and of its yaw [m, rad].

        Raises:
            CellError: If there is no such target.
        """
        raise NotImplementedError

    def ignored(self) -> Sequence[str]:
        """List the entities that are no obstacles to the opening gripper."""
        return [self.object]

    def arrived(self) -> Status:
        """Lower the object when over the target; release it at the target."""
        if self._phase == DOWN:
            return self.release()
        self._phase = DOWN
        self.feedback_message = "lowering"
        return self.begin_motion(self._lower)

    def begin_again(self) -> Status:
        """Retry the motion that another robot blocked."""
        return self.begin_motion(self._lower if self._phase == DOWN else self.start)

    def _lower(self) -> None:
        self.arm.move_linear(nearest_orientation(self._grips(), self.T_wt), speed=self.speed)

    def _grips(self) -> list[pin.SE3]:
        """List the tool poses with the held object at its target, one per quarter turn."""
        cell = self.cell
        bottom, yaw = self.target()
        T_wo = cell.pose(self.object)
        below = self._bottom_centre()
        T_wt = self.T_wt
        found = []
        for quarter in range(4):
            turn = pin.utils.rotate("z", yaw - yaw_of(T_wo) + quarter * QUARTER_TURN)
            T = pin.SE3(turn, bottom + np.array([0.0, 0.0, self.gap]) - turn @ below)
            found.append(T * T_wt)
        return found

    def _bottom_centre(self) -> np.ndarray:
        """Return the bottom centre of the object's bounding box in the world [m]."""  # (3,)
        lower, upper = extent(self.cell, self.object)
        return np.array([0.5 * (lower[0] + upper[0]), 0.5 * (lower[1] + upper[1]), lower[2]])


class PlaceOn(PlacingBehaviour):
    """Place the held object on another one, and release it.

    It is placed at the centre of the top, or at the nearest free position within reach. The support
    is an object, or a geom of an object such as ``shelf/board_1``.
    """

    support = ObjectInput(str, doc="Name of the supporting object, or of a geom: object/geom.")

    memory = (*PlacingBehaviour.memory, "_offset")

    _offset: Sequence[float] = (0.0, 0.0)  # [m] from the centre of the top, along its axes

    def begin_over(self) -> None:
        """Move over the first free position within reach."""
        support = self._support()
        offsets = support.free_offsets(self.cell, self.object)
        first: MotionError | None = None
        for offset in islice(offsets, _MAX_PLACES):
            self._offset = offset.tolist()
            try:
                return super().begin_over()
            except MotionError as error:
                if error.reason == "robot":
                    raise
                first = first or error
        if first is not None:
            raise first
        raise MotionError(f"there is no free place on '{self.support}'", reason="collision")

    def target(self) -> tuple[np.ndarray, float]:
        """Return the chosen position on the support's top, and its yaw."""
        support = self._support()
        return support.at(np.array(self._offset)), support.yaw

    def why_not_released(self, name: str) -> str:
        """Return why the object is not on the support."""
        support = self._support()
        reason = why_not_on(self.cell, name, support.entity)
        if not reason and abs(extent(self.cell, name)[0][2] - support.top[2]) > _LEVEL:
            return f"'{name}' is not at the height of '{self.support}'"
        return reason

    def _support(self) -> Support:
        if self.support == self.object:
            raise CellError(f"'{self.object}' cannot be placed on itself")
        return find_support(self.cell, self.support)


class PlaceAt(PlacingBehaviour):
    """Place the held object at a pose, and release it."""

    pose = pose_input("Target pose of its bottom centre: x;y;z;qw;qx;qy;qz [m].")
    tolerance = Input(
        float,
        default=0.01,
        doc="Largest distance of its bottom centre from the target [m].",
        at_least=0.0,
    )

    def target(self) -> tuple[np.ndarray, float]:
        """Return the position and yaw of the pose."""
        return self.pose.translation, yaw_of(self.pose)

    def why_not_released(self, name: str) -> str:
        """Return the distance of the object's bottom centre from its target, if too large."""
        distance = float(np.linalg.norm(self._bottom_centre() - self.pose.translation))
        if distance <= self.tolerance:
            return ""
        return f"'{name}' came to rest {1e3 * distance:.0f} mm from its target"
