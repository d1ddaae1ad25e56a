"""Hand-over of an object from one robot to another."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.behaviours import ArmBehaviour, PlannedMove, nearest_orientation, pose_output
from bt_manip.bt import Input, Status, Traits
from bt_manip.cell import CellError, ContactEvent, entity_of, extent
from bt_manip.exceptions import MotionError, did_you_mean
from bt_manip.kinematics import PoseTarget
from bt_manip_impedance.approach import ApproachCondition

HEIGHTS = (0.535, 0.45, 0.4, 0.35, 0.3, 0.6)
"""Heights of the hand-over above the bases, the preferred one first [m]."""

OFFSETS = (0.0, -0.05, -0.1, 0.05)
"""Distances of the object's centre from the midpoint between the robots [m]."""

HELD = 0.1
"""Time for which the receiver must keep an object after a hand-over [s]."""

FLUTTER = 20e-3
"""Longest gap in a contact that does not end it [s]."""

NEAR = 0.2
"""Distance of a tool from the object at which the progress of reaching it is a half [m]."""

_FORWARD = (0.70710678, 0.0, 0.70710678, 0.0)  # quaternion of a tool pointing along x
_HALF_TURN = pin.utils.rotate("y", math.pi)


class FindFreeEnd(ArmBehaviour):
    """Compute the pre-grasp pose for the free end of an object held by another robot.

    The free end is the end of the object's longest axis farther from the holding tool. The tool
    points along this axis, and its fingers close along the narrower one of the other axes.
    """

    traits = Traits()
    needs_gripper = True

    object = Input(str, doc="Name of the object.")
    inset = Input(float, default=0.01, doc="Distance of the grasp from the end [m].", at_least=0.0)
    distance = Input(
        float, default=0.1, doc="Distance of the pose from the grasp [m].", at_least=0.0
    )
    pose = pose_output("Pre-grasp pose of the tool in the world.")

    def start(self) -> None:
        """Compare the ends of the object."""
        cell, name = self.cell, self.object
        T_wo = cell.pose(name)
        lower, upper = extent(cell, name, T_wo)
        narrow, _, along = np.argsort(upper - lower, kind="stable")
        holder = T_wo.actInv(self._holder(name))[along]
        towards, side, grasp = np.zeros(3), np.zeros(3), 0.5 * (lower + upper)
        towards[along] = 1.0 if abs(lower[along] - holder) > abs(upper[along] - holder) else -1.0
        side[narrow] = 1.0
        end = lower[along] if towards[along] > 0.0 else upper[along]
        grasp[along] = end + (self.inset - self.distance) * towards[along]
        poses = []
        for y in (side, -side):
            R = np.column_stack((np.cross(y, towards), y, towards))
            poses.append(T_wo * pin.SE3(R, grasp))
        self.pose = nearest_orientation(poses, self.T_wt)

    def _holder(self, name: str) -> np.ndarray:
        """Return the position of the tool holding an object, in the world [m]."""  # (3,)
        for robot in self._robots.values():
            if robot.gripper is not None and name in robot.gripper.held:
                return np.array(robot.arm.model.pose(robot.robot.q).translation)
        raise CellError(f"no robot holds '{name}'")

    def update(self) -> Status:
        """Succeed; the pose is written."""
        return Status.SUCCESS


class HoldOut(PlannedMove):
    """Hold an object out to another robot, with the tool pointing at it, within reach of both.

    The object's centre is over the midpoint between the robots, or beside it if the arms block each
    other there.
    """

    needs_gripper = True

    object = Input(str, doc="Name of the held object.")
    receiver = Input(str, doc="Name of the other robot.")
    inset = Input(
        float, default=0.01, doc="Distance of both grasps from the ends [m].", at_least=0.0
    )
    distance = Input(
        float, default=0.1, doc="Distance of the receiver's approach [m].", at_least=0.0
    )

    def start(self) -> None:
        """Move to the first pose that both robots reach."""
        if self.receiver not in self._robots:
            raise CellError(
                f"there is no robot '{self.receiver}'{did_you_mean(self.receiver, self._robots)}"
            )
        first: MotionError | None = None
        for target in self._candidates():
            try:
                return self.arm.move_to_pose(target, speed=self.speed, **self.planning())
            except MotionError as error:
                if error.reason not in ("unreachable", "collision", "robot"):
                    raise
                first = first or error
        raise first or MotionError(
            f"no pose to hold '{self.object}' out at is within reach of '{self.receiver}'",
            reason="unreachable",
        )

    def why_infeasible(self) -> str:
        """Search for a pose that both robots reach."""
        for target in self._candidates():
            if next(iter(self.arm.ik.nearest_first(target, self.arm.model.home)), None):
                return ""
        pair = f"'{self.robot_name}' and '{self.receiver}'"
        return f"{pair} reach no pose to hand '{self.object}' over"

    def _candidates(self) -> Iterator[PoseTarget]:
        """Yield poses of the tool at which the receiver reaches the other end of the object."""
        sizes = np.ptp(extent(self.cell, self.object, self.cell.pose(self.object)), axis=0)
        between = float(sizes.max()) - 2.0 * self.inset
        for T_wt in self._poses(between):
            if self._is_taken(T_wt, between):
                yield PoseTarget(self.arm.ik.tool, T_wt, free_axis="z")

    def _poses(self, between: float) -> Iterator[pin.SE3]:
        """Yield poses of the tool, the preferred one first."""
        giver, receiver = (self.cell.pose(one) for one in (self.robot_name, self.receiver))
        along = receiver.translation - giver.translation
        yaw = math.atan2(along[1], along[0])
        R = pin.utils.rotate("z", yaw) @ spatial.pose((0.0, 0.0, 0.0), _FORWARD).rotation
        middle = 0.5 * (giver.translation + receiver.translation)
        for offset in OFFSETS:
            for height in HEIGHTS:
                position = middle + (offset - 0.5 * between) * R[:, 2] + (0.0, 0.0, height)
                yield pin.SE3(R, np.round(position, 9))

    def _is_taken(self, T_wt: pin.SE3, between: float) -> bool:
        """Return whether the receiver reaches the other end and its pre-grasp pose."""
        arm, a = self._robots[self.receiver].arm, T_wt.rotation[:, 2]
        q = arm.model.home
        for along in (between + self.distance, between):
            T_wr = pin.SE3(T_wt.rotation @ _HALF_TURN, T_wt.translation + along * a)
            poses = [
                T_wr * pin.SE3(pin.utils.rotate("z", k * math.pi / 2), np.zeros(3))
                for k in range(4)
            ]
            found = next(iter(arm.ik.nearest_first(poses, q)), None)
            if found is None:
                return False
            q = found.q
        return True


class IsHandedOver(ApproachCondition):
    """Check that one robot has handed an object over to another one, in the air.

    It is judged by contacts: first the giver alone touches the object, then both robots and nothing
    else, then the receiver alone for `HELD` or longer. It no longer holds when the support or,
    without the receiver, the giver touches the object again; the receiver may put it elsewhere.
    Gaps of the receiver's contact up to `FLUTTER` do not count. A goal counts hand-overs in its own
    cycle.
    """

    memory = ("_alone", "_handed_over", "_let_go", "_parted")

    giver = Input(str, doc="Name of the giving robot.")
    receiver = Input(str, doc="Name of the receiving robot.")
    support = Input(str, default="table", doc="Name of the support that it must not touch.")

    _alone = ""  # name of the last entity that touched it alone
    _handed_over = False  # whether the receiver has taken it from the giver
    _let_go: float | None = None  # [s] time from which the receiver alone has touched it
    _parted: float | None = None  # [s] time from which the receiver has not touched it

    def setup(self, **infrastructure: Any) -> None:
        """Keep the robots, and observe the contacts of the cell."""
        super().setup(**infrastructure)
        if self._observe not in self.cell.contact_changed:
            self.cell.contact_changed.append(self._observe)
            self.cell.before_remove.append(self._forget)

    def _forget(self, name: str) -> None:
        """Forget the contacts of a removed object: one added later under its name is another."""
        if name == self.object:
            self._alone, self._handed_over, self._let_go, self._parted = "", False, None, None

    def _observe(self, event: ContactEvent) -> None:
        name, giver, receiver, support = self._names()
        known = self.cell.entities.keys() >= {name, giver, receiver, support}
        if not known or name not in (entity_of(event.first), entity_of(event.second)):
            return
        others = self._partners()
        if support in others or self._is_lost(others):
            self._handed_over = False
        if receiver in others:
            self._parted = None
        elif self._parted is None:
            self._parted = event.time
        if others == {giver, receiver}:
            self._handed_over, self._let_go = self._handed_over or self._alone == giver, None
        elif others == {receiver} and self._let_go is None:
            self._let_go = event.time
        if len(others) == 1:
            (self._alone,) = others

    def _partners(self) -> set[str]:
        """Return the names of the entities that touch the object."""
        return {entity_of(other) for other in self.cell.contacts.partners(self.object)}

    @property
    def _was_kept(self) -> bool:
        """Whether the receiver alone has held it for `HELD`."""
        until = self.cell.time if self._parted is None else self._parted
        return self._let_go is not None and until - self._let_go >= HELD

    def _is_lost(self, others: set[str]) -> bool:
        """Return whether the receiver lost it too early, or the giver has it again."""
        gone = self._parted is not None and self.cell.time - self._parted > FLUTTER
        return gone and (self.giver in (self._alone, *others) or not self._was_kept)

    def _names(self) -> tuple[str, str, str, str]:
        return self.object, self.giver, self.receiver, self.support

    def why_not(self) -> str:
        """Return the conditions that the contacts do not meet."""
        for name in self._names():
            self.cell.find(name)
        if self._handed_over and not self._is_lost(self._partners()):
            text = f"'{self.giver}' has not let go of '{self.object}' for {HELD:g} s"
            return "" if self._was_kept else text
        return (
            f"'{self.giver}' has not handed '{self.object}' over to '{self.receiver}' without "
            f"putting it down on '{self.support}'"
        )

    def progress(self) -> float:
        """Return the progress of grasping, lifting and handing over, before the giver lets go."""
        name, giver, receiver, support = self._names()
        if self._handed_over:
            return 0.9
        middle = 0.5 * np.add(*extent(self.cell, name))
        robots = [self.robots[robot] for robot in (giver, receiver)]
        tools = [one.robot.tool_pose.translation for one in robots]
        near = [1.0 / (1.0 + float(np.linalg.norm(tool - middle)) / NEAR) for tool in tools]
        held = [one.gripper is not None and name in one.gripper.held for one in robots]
        if not held[0]:
            return 0.2 * near[0]
        if self.cell.contacts.touching(name, support):
            return 0.4
        return 0.5 + (0.4 if held[1] else 0.3 * near[1])
