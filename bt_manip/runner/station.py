"""A cell with its robot under control: what trees run in and scripts work with."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from dm_control import composer
from py_trees.behaviour import Behaviour

from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import Cell
from bt_manip.cell.objects import Catalogue
from bt_manip.control import Controller, GripperController
from bt_manip.motion import Arm, CollisionWorld, DeviationGuard
from bt_manip.registry import Parts, Registry
from bt_manip.robots import Robot
from bt_manip.runner.request import CONTROLLER, PLANNER
from bt_manip.runner.robot_choice import find_robot
from bt_manip.runner.scene import Scene, table_and_basket


@dataclass(frozen=True)
class Station:
    """A cell, the robot in it, and what commands that robot.

    Attributes:
        cell: The simulated cell; it is also the clock.
        robot: The robot's entity.
        arm: Moves the arm.
        controller: Makes the arm follow.
        gripper: Moves the fingers.
        rng: Where all randomness of a run comes from.
        models: Makes objects, by registered name or address, to put more into the cell.
        planners: The registered planners, for behaviours that name one.
    """

    cell: Cell
    robot: Robot
    arm: Arm
    controller: Controller
    gripper: GripperController
    rng: np.random.Generator
    models: Catalogue
    planners: Registry[Any]

    @property
    def infrastructure(self) -> dict[str, Any]:
        """What behaviours get from their ``setup``, by keyword."""
        return {
            "cell": self.cell,
            "robot": self.robot,
            "arm": self.arm,
            "gripper": self.gripper,
            "rng": self.rng,
            "models": self.models,
            "planners": self.planners,
        }

    def clock(self) -> float:
        """Give simulated time, for trees that run here [s]."""
        return self.cell.time

    def step_until(self, condition: Callable[[], bool], timeout: float = 10.0) -> None:
        """Make control steps until something has happened.

        Args:
            condition: Tells whether it has; asked before each step.
            timeout: Longest simulated time to wait [s].

        Raises:
            TimeoutError: When it has not happened within that time.
        """
        for _ in range(round(timeout / self.cell.dt)):
            if condition():
                return
            self.cell.step()
        if not condition():
            raise TimeoutError(f"what was waited for has not happened within {timeout:g} s")

    def run(
        self, tree: Tree | Behaviour, *, tick: float = 0.010, timeout: float = 60.0
    ) -> NodeStatus:
        """Run a tree once, from idle to its end.

        Args:
            tree: A tree whose clock is that of this station, or the root of one.
            tick: Simulated time between two ticks [s].
            timeout: Longest simulated time that it may take [s].

        Returns:
            How it ended: ``SUCCESS``, ``FAILURE``, or ``SKIPPED`` when there was nothing to do.

        Raises:
            TimeoutError: When it takes longer; the tree has been halted then.
        """
        if not isinstance(tree, Tree):
            tree = Tree(tree, clock=self.clock)
        tree.setup(**self.infrastructure)
        steps = max(1, round(tick / self.cell.dt))
        end = self.cell.time + timeout
        while (status := tree.tick()) is NodeStatus.RUNNING:
            if self.cell.time >= end:
                running = [n.path for n in tree.nodes if n.engine_status is NodeStatus.RUNNING]
                tree.halt()
                raise TimeoutError(f"after {timeout:g} s the tree is still at '{running[-1]}'")
            self.cell.step(steps)
        return status

    def get_state(self) -> dict[str, Any]:
        """Give everything that goes on with time, as plain data."""
        return {
            "cell": self.cell.get_state(),
            "arm": self.arm.get_state(),
            "controller": self.controller.get_state(),
            "gripper": self.gripper.get_state(),
            "rng": self.rng.bit_generator.state,
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Take everything back; the station goes on bit for bit.

        Raises:
            CellError: When an object of the state is not registered here.
        """

        def make(entry: Mapping[str, Any]) -> composer.Entity:
            return self.models.create(entry["kind"], **entry["parameters"])

        self.cell.set_state(state["cell"], make)
        self.arm.set_state(state["arm"])
        self.controller.set_state(state["controller"])
        self.gripper.set_state(state["gripper"])
        self.rng.bit_generator.state = state["rng"]


def build_station(
    parts: Parts | None = None,
    *,
    robot: str = "panda",
    controller: str = CONTROLLER,
    planner: str = PLANNER,
    scene: Scene | None = None,
    seed: int = 0,
    catalogue: Catalogue | None = None,
) -> Station:
    """Build a cell and put a robot in it, at home, under control.

    Args:
        parts: The registered parts to choose from; default: those of all installed plugins.
        robot: Name of a registered robot, or path of a TOML file that describes one.
        controller: Name of a registered controller.
        planner: Name of a registered planner.
        scene: What stands in the cell; default: a table and a basket.
        seed: Seed of the station's randomness.
        catalogue: Makes the objects; default: one of the registered parts.

    Raises:
        BtManipError: When a name is not registered or a model does not compile.
    """
    if parts is None:
        from bt_manip.plugins import load_plugins

        parts = load_plugins().parts
    scene = scene or table_and_basket()
    catalogue = catalogue or Catalogue(parts.objects, sources=parts.model_sources)
    arm_entity = Robot(find_robot(robot, parts.robots))
    make_controller = parts.controllers.get(controller)
    make_planner = parts.planners.get(planner)
    fixtures = [(f, catalogue.create(f.model, **f.parameters)) for f in scene.fixtures]
    control = make_controller(arm_entity)
    gripper = GripperController(arm_entity)
    arm_entity.attach(control)
    arm_entity.attach(gripper)
    cell = Cell()
    with cell.editing():
        for fixture, entity in fixtures:
            cell.add(entity, fixture.T_wo, name=fixture.name, free=fixture.free)
        cell.add(arm_entity, scene.T_wb, free=False)
    model = arm_entity.make_model()
    arm = Arm(
        arm_entity,
        model=model,
        world=CollisionWorld(arm_entity, model),
        planner=make_planner(),
        guard=DeviationGuard(arm_entity, model),
    )
    control.reference = arm
    rng = np.random.default_rng(seed)
    return Station(cell, arm_entity, arm, control, gripper, rng, catalogue, parts.planners)
