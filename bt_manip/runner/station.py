"""A station: a cell with its robots under control, for trees and scripts."""

import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from dm_control import composer
from py_trees.behaviour import Behaviour

from bt_manip.arm import Arm
from bt_manip.bt import AlwaysSuccess, NodeStatus, Tree
from bt_manip.cell import Cell
from bt_manip.cell.objects import Catalogue
from bt_manip.cell.randomization import Randomizer
from bt_manip.control import Controller, ControllerManager
from bt_manip.files import noting
from bt_manip.registry import Parts
from bt_manip.robots import Gripper, Robot
from bt_manip.scenes import (
    ExpectedObjects,
    Scene,
    find_scene,
    make_pose_source,
    naming_file,
    object_models,
    place_again,
    with_models,
)

from .believed import Believed, BelievedHardware
from .commanded_robot import CommandedRobot, NoOnlyRobot, chosen_robots
from .filled_cell import FilledCell
from .hardware import Hardware
from .loop import RunLoop
from .notebook import html_image, html_table
from .observer import recorder_for
from .real_robot import find_backend
from .request import TICK, RunRequest
from .run import Run
from .tree_source import TreeSource


@dataclass(frozen=True)
class TreeResult:
    """How a tree ended.

    Attributes:
        status: ``SUCCESS``, ``FAILURE``, or ``SKIPPED`` if its precondition skipped it. A tree
            whose goal does not hold has failed.
        reason: The node that failed, and why, or why the goal does not hold; empty on success.
        duration: Simulated time that it took [s].
        recording: The file that it was recorded to, if any.
    """

    status: NodeStatus
    reason: str = ""
    duration: float = 0.0
    recording: Path | None = None

    def _repr_html_(self) -> str:
        """Show all this in a notebook."""
        duration = f"{self.duration:.2f} s"
        rows = {"reason": self.reason, "duration": duration, "recording": self.recording}
        return html_table(self.status.name, rows)

    def __str__(self) -> str:
        """Return the status, with the reason of a failure."""
        return f"{self.status.name}: {self.reason}" if self.reason else self.status.name


@dataclass(frozen=True)
class Station:
    """A cell, and its robots with their arms, controllers and grippers.

    Attributes:
        cell: The simulated cell; it is also the clock.
        robots: The robots by name, in the scene's order.
        rng: Random generator of the run.
        models: Makes objects by registered name or address.
        parts: The registered parts.
        randomizer: Randomizes the cell at the beginning of a cycle.
        scene: The scene that it was built with.
        request: The request that it was built from.
        poses: The objects that the scene expects; None where the physics decides the poses.
        hardware: Executes the control steps.
        files: SHA-256 of the files that it was built from, and of those that its trees loaded, by
            name.
        believed: The cell that trees know, where it is not that of the physics.
    """

    cell: Cell
    robots: Mapping[str, CommandedRobot]
    rng: np.random.Generator
    models: Catalogue
    parts: Parts
    randomizer: Randomizer
    scene: Scene
    request: RunRequest
    poses: ExpectedObjects | None
    hardware: Hardware
    files: dict[str, str] = field(default_factory=dict)
    believed: Believed | None = None

    def model_warnings(self) -> list[str]:
        """Return what is strange in the model files of its robots and objects, or was lost."""
        of_robots = [text for one in self.robots.values() for text in one.robot.warnings]
        return list(dict.fromkeys([*of_robots, *self.models.warnings()]))

    @property
    def first(self) -> CommandedRobot:
        """The only robot, or the first of several."""
        return next(iter(self.robots.values()))

    @property
    def robot(self) -> Robot:
        """The entity of the only robot, or of the first of several."""
        return self.first.robot

    @property
    def arm(self) -> Arm:
        """The arm of the only robot, or of the first of several."""
        return self.first.arm

    @property
    def controller(self) -> Controller:
        """The active controller of the only robot, or of the first of several."""
        return self.first.controller

    @property
    def controllers(self) -> ControllerManager:
        """The controllers of the only robot, or of the first of several."""
        return self.first.controllers

    @property
    def gripper(self) -> Gripper:
        """The gripper of the only robot, or of the first of several.

        Raises:
            GripperError: When it has none.
        """
        return self.first.robot.needed_gripper

    @property
    def infrastructure(self) -> dict[str, Any]:
        """Keyword arguments of the behaviours' ``setup``, with the parts of declared kinds.

        Where there are several robots, ``robot``, ``arm``, ``controllers`` and ``gripper``
        raise when they are used. ``sensors`` are the entities of that category by name, which
        sense the physics. With a believed cell, everything else belongs to it, and ``judged`` is
        what the goal gets.
        """
        believed = self.believed
        if believed is None:
            return self._infrastructure(self.cell, self.robots, self.poses)
        return {
            **self._infrastructure(believed.cell, believed.robots, believed.poses),
            "judged": self._infrastructure(self.cell, self.robots, None),
        }

    def _infrastructure(
        self, cell: Cell, robots: Mapping[str, CommandedRobot], poses: ExpectedObjects | None
    ) -> dict[str, Any]:
        only = next(iter(robots.values())) if len(robots) == 1 else None
        none = NoOnlyRobot(robots)
        return {
            **self.parts.declared,
            "cell": cell,
            "robots": robots,
            "robot": only.robot if only else none,
            "arm": only.arm if only else none,
            "controllers": only.controllers if only else none,
            "gripper": only.gripper if only else none,
            "rng": self.rng,
            "models": self.models,
            "planners": self.parts.planners,
            "poses": poses,
            "sensors": {
                name: entity for name, entity in self.cell.entities.items()
                if getattr(entity, "category", "") == "sensor"
            },
        }  # fmt: skip

    def clock(self) -> float:
        """Return the simulated time [s]."""
        return self.cell.time

    def step_until(
        self, condition: Callable[[], bool], timeout: float = 10.0, *, steps: int = 1
    ) -> None:
        """Step until a condition holds.

        Args:
            condition: Called before the steps.
            timeout: Longest simulated time to wait [s].
            steps: Number of control steps between two calls of the condition.

        Raises:
            TimeoutError: If it does not hold within that time.
        """
        with RunLoop(self.resting()) as loop:
            end = self.cell.time + timeout - 0.5 * self.cell.dt
            while not (met := condition()) and self.cell.time < end:
                loop.step(steps)
        if not met:
            raise TimeoutError(f"the condition was not met within {timeout:g} s")

    def run(
        self,
        tree: Tree | Behaviour,
        *,
        tick: float = TICK,
        timeout: float = 60.0,
        record: str | os.PathLike[str] | None = None,
    ) -> TreeResult:
        """Run a tree once and return its status, and why it failed.

        Args:
            tree: A tree, or the root of one. A tree without a clock of its own gets that of this
                station.
            tick: Simulated time between two ticks [s].
            timeout: Longest simulated time [s].
            record: File to record it to; its suffix chooses the recorder, as in ``run.mcap``.

        Raises:
            TimeoutError: If it takes longer; the tree is halted and the arms are stopped.
            BtManipError: If no recorder writes such files, or it cannot write this one.
        """
        if not isinstance(tree, Tree):
            tree = Tree(tree, clock=self.clock)
        elif tree.clock is time.monotonic:  # the default
            tree.clock = self.clock
        path = None if record is None else Path(record)
        observers = () if path is None else (recorder_for(path, self.parts.recorders),)
        tree.setup(**self.infrastructure)
        cell, start = self.cell, self.cell.time
        request = replace(self.request, tree=TreeSource(tree.tree_id, "python"), tick=tick)
        run = Run(request, tree, self)

        def late() -> bool:
            running = [n.path for n in tree if n.engine_status is NodeStatus.RUNNING]
            if cell.time < start + timeout or not running:
                return False
            raise TimeoutError(f"after {timeout:g} s the tree is still at '{running[-1]}'")

        with RunLoop(run, observers) as loop:
            ended = loop.cycle(in_place=True, stop=late)
        assert ended is not None
        succeeded = ended.succeeded or ended.status is not NodeStatus.SUCCESS
        status = ended.status if succeeded else NodeStatus.FAILURE
        return TreeResult(status, ended.reason, cell.time - start, path)

    def resting(self) -> Run:
        """Return a run of this station in which no tree acts."""
        return Run(self.request, Tree(AlwaysSuccess()), self)

    def __repr__(self) -> str:
        """Show the robots and the cell."""
        return f"Station(robots: {', '.join(self.robots)}; {self.cell!r})"

    def _repr_html_(self) -> str:
        """Show the robots, the objects and a picture in a notebook."""
        robots = {
            name: f"{one.chosen.description}, {one.chosen.controller}"
            for name, one in self.robots.items()
        }
        rows = robots | {"objects": ", ".join(self.cell.objects), "time": f"{self.cell.time:.2f} s"}
        return html_table("Station", rows) + html_image(self.cell._repr_png_())

    def reseed(self, seed: int) -> None:
        """Continue as if it had been built with another seed.

        Sampled objects get new poses; the cell must be as it was built.

        Raises:
            CellError: If there is no free pose for an object.
        """
        self.rng.bit_generator.state = np.random.default_rng(seed).bit_generator.state
        with naming_file(self.scene):
            moved = place_again(self.cell, self.scene.objects, seed)
        self.randomizer.reseed(seed, moved)

    def get_state(self) -> dict[str, Any]:
        """Return the state of the station as plain data."""
        more: dict[str, Any] = {} if self.poses is None else {"poses": self.poses.get_state()}
        if self.believed is not None:
            more["believed"] = self.believed.get_state()
        return more | {
            "cell": self.cell.snapshot(),
            "robots": {name: robot.get_state() for name, robot in self.robots.items()},
            "rng": self.rng.bit_generator.state,
            "randomizer": self.randomizer.get_state(),
        }

    def begin_cycle(self, cycle: int) -> None:
        """Randomize the cell for a cycle."""
        self.randomizer.begin(cycle)
        if self.believed is not None:
            self.believed.begin()

    def return_to(self, state: Mapping[str, Any]) -> None:
        """Return to a state of `get_state`, while time and random generators go on.

        Raises:
            CellError: As for `set_state`.
        """
        cell = self.cell
        drawn, noise = self.rng.bit_generator.state, cell.random_state.get_state()
        self.set_state(state, time=cell.time)
        self.rng.bit_generator.state = drawn
        cell.random_state.set_state(noise)

    def set_state(self, state: Mapping[str, Any], *, time: float | None = None) -> None:
        """Restore a state of `get_state`; the station continues bit for bit.

        Args:
            state: The state.
            time: Simulated time afterwards [s]; None: that of the state.

        Raises:
            CellError: If an object of the state is not registered here.
            ModelError: If the model of an object would have to be downloaded.
        """

        def make(entry: Mapping[str, Any]) -> composer.Entity:
            return self.models.restored(entry["kind"], entry["parameters"])

        self.cell.restore(state["cell"], make, time=time)
        if self.believed is not None:
            self.believed.set_state(state["believed"], make)
        for name, robot in self.robots.items():
            robot.set_state(state["robots"][name])
        self.rng.bit_generator.state = state["rng"]
        self.randomizer.set_state(state["randomizer"])
        if self.poses is not None:
            self.poses.set_state(state.get("poses", ()))


def make_station(request: RunRequest, parts: Parts, *, first_cycle: bool = False) -> Station:
    """Build a cell with its robots at home and under control.

    All registered controllers can be switched to. The first cycle may be randomized already, which
    finds variations that are impossible. Unknown names and models that do not compile raise a
    `BtManipError`.
    """
    files: dict[str, str] = {}
    with noting(files):
        return replace(_make_station(request, parts, first_cycle), files=files)


def _make_station(request: RunRequest, parts: Parts, first_cycle: bool) -> Station:
    found, seed = find_scene(request.scene, parts), request.seed
    catalogue = Catalogue(parts.objects, sources=parts.model_sources, formats=parts.model_formats)
    scene = with_models(found, object_models(request.settings, found), catalogue)
    backend = find_backend(request.backend, parts)
    backend.check(scene)
    source = make_pose_source(request.poses, parts.pose_sources, scene.objects)
    # Of a real robot, the cell itself is what is believed.
    make_believed = None if source is None or request.backend else source.believed_cell
    described = scene
    if make_believed is not None:
        scene = replace(scene, objects=tuple(replace(o, expected=False) for o in scene.objects))
    chosen = chosen_robots(request, scene, parts)
    builders = [backend.builder(one, parts) for one in chosen]
    filled = FilledCell(scene, builders, catalogue, seed)
    cell, robots = filled.cell, filled.robots
    believed: Believed | None = None
    if make_believed is not None:
        believed = make_believed(
            scene=described, chosen=chosen, cell=cell, robots=robots, source=source, parts=parts,
            catalogue=catalogue, seed=seed,
        )  # fmt: skip
        twins = believed.robots
        robots = {name: replace(one, arm=twins[name].arm) for name, one in robots.items()}
    for one in (*robots.values(), *(() if believed is None else believed.robots.values())):
        one.robot.configurations |= scene.configurations
    for one in robots.values():
        one.arm.speed_factor = request.speed_factor
        one.arm.follower.speed_scale *= request.speed_factor
    randomizer = filled.make_randomizer(catalogue, seed)
    if first_cycle:
        with naming_file(scene):
            randomizer.begin(0)
    poses = None
    hardware: Hardware
    if believed is not None:
        believed.begin()
        hardware = BelievedHardware(cell, believed)
    else:
        hardware = backend.hardware(cell, robots)
        poses = None if source is None else ExpectedObjects(source, cell, catalogue)
    return Station(
        cell, robots, np.random.default_rng(seed), catalogue, parts, randomizer, scene, request,
        poses, hardware, believed=believed,
    )  # fmt: skip
