"""A robot with what commands it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from bt_manip.arm import Arm, ExternalForceGuard
from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld
from bt_manip.control import Controller, GripperController
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.robots import Robot
from bt_manip.runner.robot_choice import find_robot
from bt_manip.runner.scene import SceneRobot


@dataclass(frozen=True)
class CommandedRobot:
    """One robot of a station.

    Attributes:
        name: Its name in the cell.
        robot: Its entity.
        arm: Moves the arm.
        controller: Makes the arm follow.
        gripper: Moves the fingers.
    """

    name: str
    robot: Robot
    arm: Arm
    controller: Controller
    gripper: GripperController

    def get_state(self) -> dict[str, Any]:
        """Give everything of it that goes on with time, as plain data; the cell has the rest."""
        return {
            "arm": self.arm.get_state(),
            "controller": self.controller.get_state(),
            "gripper": self.gripper.get_state(),
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Take everything back."""
        self.arm.set_state(state["arm"])
        self.controller.set_state(state["controller"])
        self.gripper.set_state(state["gripper"])


class NoOnlyRobot:
    """What behaviours get for the only robot's arm where there are several: an error at any use."""

    def __init__(self, names: Iterable[str]) -> None:
        """Know what they could have asked for.

        Args:
            names: Names of the robots.
        """
        vars(self)["_names"] = ", ".join(f"'{name}'" for name in names)

    def __getattr__(self, attribute: str) -> Any:
        """Refuse.

        Raises:
            BtManipError: Always.
        """
        if attribute.startswith("__"):
            raise AttributeError(attribute)
        raise BtManipError(
            f"the cell has the robots {vars(self)['_names']}, and this behaviour asks for the only "
            "one; derive it from ArmBehaviour, or take one of 'robots' in its setup"
        )


class RobotEntities:
    """The composer entities of one robot of a scene, before and while it becomes commanded."""

    def __init__(self, chosen: SceneRobot, parts: Parts) -> None:
        """Make the robot, its controller and its gripper's.

        Args:
            chosen: The robot, with all names that a scene may leave open.
            parts: The registered parts.

        Raises:
            BtManipError: When a name is not registered or a model does not load.
        """
        assert chosen.description and chosen.controller and chosen.planner
        self._chosen = chosen
        self._make_planner = parts.planners.maker(chosen.planner, "plan")
        self._robot = Robot(find_robot(chosen.description, parts.robots))
        make_controller = parts.controllers.maker(chosen.controller, "compute", "mjcf_model")
        self._controller = make_controller(self._robot)
        self._gripper = GripperController(self._robot)
        self._robot.attach(self._controller)
        self._robot.attach(self._gripper)

    def put_into(self, cell: Cell) -> str:
        """Put the robot at its place in a cell; give the name it got."""
        return cell.add(self._robot, self._chosen.T_wb, name=self._chosen.name or None, free=False)

    def commanded(self, name: str) -> CommandedRobot:
        """Give the robot something that moves it; the cell must be compiled."""
        robot = self._robot
        model = robot.make_model()
        arm = Arm(
            robot,
            model=model,
            world=CollisionWorld(robot, model),
            planner=self._make_planner(),
            guard=ExternalForceGuard(robot, model),
        )
        self._controller.reference = arm
        return CommandedRobot(name, robot, arm, self._controller, self._gripper)
