"""A robot of a station, with its arm, controllers and gripper."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm, ExternalForceGuard
from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld, check_home
from bt_manip.control import Controller, ControllerManager
from bt_manip.exceptions import BtManipError
from bt_manip.grasping import GraspPlanner, ReachFromAbove
from bt_manip.registry import Parts
from bt_manip.robots import Gripper, Robot, compile_alone
from bt_manip.scenes import Scene, SceneRobot, find_robot

from .hardware import Hardware

if TYPE_CHECKING:
    from .request import RunRequest


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


def chosen_robots(request: "RunRequest", scene: Scene, parts: Parts) -> list[SceneRobot]:
    """Return the robots of a scene with the request's choices where they make none."""
    return [
        _at_reach(
            replace(
                one,
                description=one.description or request.robot,
                controller=one.controller or request.controller,
                planner=one.planner or request.planner,
                tool_speed=request.tool_speed or one.tool_speed,
            ),
            parts,
        )
        for one in scene.robots
    ]


def _at_reach(chosen: SceneRobot, parts: Parts) -> SceneRobot:
    """Return a robot of a scene where an arm of its reach stands: see `SceneRobot.for_reach`."""
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


def make_robot(
    chosen: SceneRobot,
    parts: Parts,
    make_gripper: Callable[[str], Any] | None = None,
    tool_speed: float | None = None,
) -> Robot:
    """Make the entity of a robot of a scene, with its gripper.

    Args:
        chosen: The robot.
        parts: The registered parts.
        make_gripper: Returns the factory of a gripper of a kind; default: that of the parts, or of
            the controller where it brings grippers of its own.
        tool_speed: Limit of the tool's speed where neither the scene nor the description has one
            [m/s].

    Raises:
        BtManipError: If a name is not registered or a model does not load.
    """
    assert chosen.description
    description = find_robot(chosen.description, parts.robots)
    limit = chosen.tool_speed or description.tool_speed or tool_speed
    if limit != description.tool_speed:
        description = replace(description, tool_speed=None if limit == inf else limit)
    if description.gripper is None:
        return Robot(description, bounds=chosen.bounds)
    kind = description.gripper.kind
    if make_gripper is not None:
        return Robot(description, gripper=make_gripper(kind), bounds=chosen.bounds)
    if chosen.controller:
        kind = getattr(parts.controllers.get(chosen.controller), "grippers", {}).get(kind, kind)
    made = parts.grippers.maker(kind, "close", "held_root")
    return Robot(description, gripper=made, bounds=chosen.bounds)


class RobotBuilder:
    """Builds one robot of a scene: its entities first, its arm when the cell is compiled.

    Args:
        chosen: The robot, with all optional names filled in.
        parts: The registered parts.

    Raises:
        BtManipError: If a name is not registered, or a model does not load.
    """

    def __init__(self, chosen: SceneRobot, parts: Parts) -> None:
        assert chosen.controller and chosen.planner
        self._chosen = chosen
        self._make_planner = parts.planners.maker(chosen.planner, "plan")
        self._robot = self._make_robot(parts)
        self._controllers = ControllerManager(
            self._robot, self._controller_factories(parts), chosen.controller
        )
        self._robot.attach(self._controllers)

    def put_into(self, cell: Cell) -> str:
        """Add the robot to a cell at its pose; return the name it got."""
        return cell.add(self._robot, self._chosen.T_wb, name=self._chosen.name or None, free=False)

    def commanded(self, name: str, cell: Cell) -> CommandedRobot:
        """Return the robot with an arm that commands its controllers; the cell is compiled."""
        robot = self._robot
        model = robot.make_model()
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

    def _make_robot(self, parts: Parts) -> Robot:
        return make_robot(self._chosen, parts)

    def _controller_factories(self, parts: Parts) -> dict[str, Callable[..., Controller]]:
        registered = parts.controllers
        registered.get(str(self._chosen.controller))  # raises if there is none
        return {n: registered.maker(n, "compute", "mjcf_model") for n in registered.names()}


class Simulation:
    """Simulates the robots of a scene; a `RealBackend` connects to a real one instead.

    Runs that choose no controller have the `default_controller`; None: that of the request.
    """

    default_controller: str | None = None

    def check(self, scene: Scene) -> None:
        """Raise a `BtManipError` for a scene that is impossible."""

    def builder(self, chosen: SceneRobot, parts: Parts) -> RobotBuilder:
        """Return the builder of a robot of the scene."""
        return RobotBuilder(chosen, parts)

    def hardware(self, cell: Cell, robots: Mapping[str, CommandedRobot]) -> Hardware:
        """Return the hardware that executes the control steps of the robots."""
        return Hardware(cell)
