"""The port for the robot of a behaviour."""

import contextlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from bt_manip.arm import Arm
from bt_manip.bt import Input
from bt_manip.bt.nodes import Condition, Node
from bt_manip.cell import CellError
from bt_manip.control import ControllerManager
from bt_manip.exceptions import PortError, did_you_mean
from bt_manip.grasping import GraspPlanner
from bt_manip.robots import Gripper, GripperError

if TYPE_CHECKING:
    from bt_manip.runner import CommandedRobot

ENTRY = "robot"
"""Blackboard entry that selects the robot if the port does not."""


class RobotPort(Node):
    """A behaviour of one robot.

    The robot is selected by the port, by the entry ``robot`` of the blackboard scope (as in a
    sub-tree with ``robot="left"``), or else it is the only robot of the cell.
    """

    robot = Input(
        str,
        default="",
        doc="Name of the robot; by default that of the scope's entry 'robot', or the only one.",
    )

    memory: ClassVar[tuple[str, ...]] = ("_robot_name",)

    needs_gripper: ClassVar[bool] = False
    """Whether it fails if the robot has no gripper."""

    _robot_name = ""

    def setup(self, **infrastructure: Any) -> None:
        """Store the robots, and select one if it is already known.

        Raises:
            CellError: If there are several and none is named, or none has the name.
        """
        super().setup(**infrastructure)
        self._robots: Mapping[str, CommandedRobot] = infrastructure["robots"]
        # The entry may be written later. A missing gripper fails the behaviour, not the run.
        with contextlib.suppress(PortError, GripperError):
            self.choose_robot()

    def choose_robot(self) -> None:
        """Select the robot.

        Raises:
            CellError: If there are several and none is named, or none has the name.
            GripperError: If the robot lacks a required gripper.
            PortError: If the port refers to an entry that was never written.
        """
        name = self.robot
        if not name and ENTRY in self.scope:
            name = str(self.scope[ENTRY])
        if not name:
            if len(self._robots) > 1:
                known = ", ".join(f"'{known}'" for known in self._robots)
                raise CellError(
                    f"the cell has the robots {known}; select one by the port robot, here or at "
                    "the sub-tree"
                )
            name = next(iter(self._robots))
        if name not in self._robots:
            raise CellError(f"there is no robot '{name}'{did_you_mean(name, self._robots)}")
        self._robot_name = name
        if self.needs_gripper:
            _ = self.gripper

    @property
    def robot_name(self) -> str:
        """Name of the selected robot."""
        return self._robot_name

    @property
    def arm(self) -> Arm:
        """Arm of the selected robot."""
        return self._robots[self._robot_name].arm

    @property
    def controllers(self) -> ControllerManager:
        """Controllers of the selected robot."""
        return self._robots[self._robot_name].controllers

    @property
    def grasp_planner(self) -> GraspPlanner:
        """Grasp planner of the selected robot."""
        return self._robots[self._robot_name].grasp_planner

    @property
    def gripper(self) -> Gripper:
        """Gripper of the selected robot.

        Raises:
            GripperError: If it has none.
        """
        gripper = self._robots[self._robot_name].gripper
        if gripper is None:
            raise GripperError(f"robot '{self._robot_name}' has no gripper")
        return gripper


class RobotCondition(RobotPort, Condition):
    """A condition on one robot."""

    def initialise(self) -> None:
        """Select the robot."""
        try:
            self.choose_robot()
        except (CellError, GripperError) as error:
            self.fail(str(error))
