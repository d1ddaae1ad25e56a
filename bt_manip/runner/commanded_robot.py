"""A robot of a station, with its arm, controllers and gripper."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm, ExternalForceGuard
from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld, check_home
from bt_manip.control import Controller, ControllerManager, MeasuredArm
from bt_manip.exceptions import BtManipError
from bt_manip.grasping import GraspPlanner, ReachFromAbove
from bt_manip.registry import Parts
from bt_manip.robots import ArmConnection, Gripper, Robot, compile_alone
from bt_manip.scenes import SceneRobot, find_robot

from .real_robot import BackendChoice


@dataclass(frozen=True)
class CommandedRobot:
    """One robot of a station.

    Attributes:
        name: Its name in the cell.
        robot: Its entity.
        arm: Plans and executes the motions of the arm.
        controllers: The arm's torque controllers, one of them active.
        gripper: Its gripper; None where it has none.
        grasp_planner: Chooses its grasps.
        chosen: The names of its description, its first controller and its planner.
    """

    name: str
    robot: Robot
    arm: Arm
    controllers: ControllerManager
    gripper: Gripper | None
    grasp_planner: GraspPlanner
    chosen: SceneRobot

    @cached_property
    def reach(self) -> ReachFromAbove:
        """Finds where the arm reaches from above."""
        return ReachFromAbove(self.arm)

    @property
    def controller(self) -> Controller:
        """The active controller."""
        return self.controllers.controller

    def get_state(self) -> dict[str, Any]:
        """Return its state besides the physics, as plain data."""
        return {
            "arm": self.arm.get_state(),
            "controllers": self.controllers.get_state(),
            "gripper": None if self.gripper is None else self.gripper.get_state(),
            "grasp_plan": self.grasp_planner.get_state(),
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of `get_state`."""
        self.controllers.reference = self.arm
        self.arm.set_state(state["arm"])
        self.controllers.set_state(state["controllers"])
        if self.gripper is not None:
            self.gripper.set_state(state["gripper"])
        self.grasp_planner.set_state(state.get("grasp_plan"))


class NoOnlyRobot:
    """Stands for parts of the only robot where there are several: any use is an error."""

    def __init__(self, names: Iterable[str]) -> None:
        """Keep the names for the message.

        Args:
            names: Names of the robots.
        """
        vars(self)["_names"] = ", ".join(f"'{name}'" for name in names)

    def __getattr__(self, attribute: str) -> Any:
        """Raise a `BtManipError`."""
        if attribute.startswith("__"):
            raise AttributeError(attribute)
        raise BtManipError(
            f"the cell has the robots {vars(self)['_names']}, and this behaviour asks for the only "
            "one; derive it from ArmBehaviour, or take one of 'robots' in its setup"
        )


_APART = 0.15  # [m] of the tool at home from the world's origin, where another robot may be
_SAME_REACH = 0.02  # relative difference from the reach that a scene is made for


def at_reach(chosen: SceneRobot, parts: Parts) -> SceneRobot:
    """Return a robot of a scene where an arm of its reach stands: see `SceneRobot.for_reach`.

    Args:
        chosen: The robot, with all optional names filled in.
        parts: The registered parts.

    Raises:
        BtManipError: If a name is not registered or a model does not load.
    """
    if chosen.for_reach is None:
        return chosen
    robot = make_robot(chosen, parts)
    compile_alone(robot)
    model, T_wb = robot.make_model(), chosen.T_wb
    scale = model.reach / chosen.for_reach
    scale = 1.0 if abs(scale - 1.0) < _SAME_REACH else scale
    shoulder = model.model.jointPlacements[1].translation
    x, y = T_wb.translation[:2]
    outwards = np.linalg.norm((model.pose(model.home).translation - shoulder)[:2])
    scale = max(scale, (outwards + _APART) / np.hypot(x, y))
    position = scale * T_wb.translation - T_wb.rotation @ shoulder
    position[2] = T_wb.translation[2]
    return replace(chosen, T_wb=pin.SE3(T_wb.rotation, position))


def make_robot(chosen: SceneRobot, parts: Parts, backend: BackendChoice | None = None) -> Robot:
    """Make the entity of a robot of a scene, with its gripper, which a backend may move.

    Raises:
        BtManipError: If a name is not registered or a model does not load.
    """
    assert chosen.description
    description = find_robot(chosen.description, parts.robots)
    make_gripper = None
    if description.gripper is not None:
        name = description.gripper.kind
        if backend is None and chosen.controller:
            first = parts.controllers.get(chosen.controller)  # may bring grippers of its own
            name = getattr(first, "grippers", {}).get(name, name)
        make_gripper = parts.grippers.maker(name, "close", "held_root")
        if backend is not None:
            kind: Any = parts.grippers.get(name)
            make_gripper = kind.on_device(backend.connect_gripper())
    return Robot(description, gripper=make_gripper, bounds=chosen.bounds)


class RobotEntities:
    """The composer entities of one robot of a scene, before the cell is compiled."""

    def __init__(
        self, chosen: SceneRobot, parts: Parts, backend: BackendChoice | None = None
    ) -> None:
        """Make the robot with its gripper, and its controllers.

        Args:
            chosen: The robot, with all optional names filled in.
            parts: The registered parts.
            backend: The real robot; None simulates it.

        Raises:
            BtManipError: If a name is not registered, a model does not load, or the real robot
                cannot be reached.
        """
        assert chosen.description and chosen.controller and chosen.planner
        self._chosen = chosen
        self._make_planner = parts.planners.maker(chosen.planner, "plan")
        if backend is not None:
            backend.check_controller(chosen.controller)
        self._robot = make_robot(chosen, parts, backend)
        controllers = parts.controllers
        self.connection: ArmConnection | None = None
        if backend is not None:
            self.connection = backend.connect_arm(self._robot.limits)
            make: Any = partial(MeasuredArm, connection=self.connection)
            factories = dict.fromkeys(backend.backend.controllers, make)
        else:
            controllers.get(chosen.controller)  # raises if there is none
            factories = {
                name: controllers.maker(name, "compute", "mjcf_model")
                for name in controllers.names()
            }
        self._controllers = ControllerManager(self._robot, factories, chosen.controller)
        self._robot.attach(self._controllers)

    def put_into(self, cell: Cell) -> str:
        """Add the robot to a cell at its pose; return the name it got."""
        return cell.add(self._robot, self._chosen.T_wb, name=self._chosen.name or None, free=False)

    def commanded(self, name: str, cell: Cell) -> CommandedRobot:
        """Connect the arm to the controllers; the cell must be compiled."""
        robot = self._robot
        model = robot.make_model()
        if self.connection is not None:
            self.connection.set_limits(model.limits)
        world = CollisionWorld(robot, model)
        check_home(world)
        arm = Arm(
            robot,
            model=model,
            world=world,
            planner=self._make_planner(),
            guard=ExternalForceGuard(robot, model),
        )
        self._controllers.reference = arm
        controllers, planner = self._controllers, GraspPlanner(cell, arm)
        return CommandedRobot(name, robot, arm, controllers, robot.gripper, planner, self._chosen)
