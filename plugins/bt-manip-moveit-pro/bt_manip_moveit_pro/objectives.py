"""Which objectives of a workspace of MoveIt Pro have all their leaves, and run."""

import contextlib
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_manip.bt import (
    KeepRunningUntilFailure,
    Libraries,
    Node,
    NodeStatus,
    ReadingOptions,
    Repeat,
    read_tree,
)
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.robots import load_configurations
from bt_manip.runner import Run, RunLoop, RunRequest, find_tree, known_behaviours, prepare
from bt_manip_moveit_pro.values import JointState

ROBOTS = ("ur5e", "gen3", "panda")
"""Robots on which objectives run: the first whose joints a waypoint of the folder names."""

ROUNDS = 2
"""Number of rounds of an endless loop after which a run is stopped."""

SECONDS = 120.0
"""Simulated time after which a run is stopped [s]."""

SHOWN = 3
"""Number of missing leaves that a row of the table names."""

SCENE = Path(__file__).parent / "scenes" / "robot_alone.toml"
UNKNOWN = re.compile(r"no (?:node|tree) is named '([^']*)'")


@dataclass(frozen=True)
class Result:
    """A line of the table.

    Attributes:
        path: The file, relative to the workspace.
        lacks: Names of leaves and sub-trees that nobody has, and other errors.
        robot: The robot of the run; empty where it was not run.
        outcome: ``SUCCESS``, ``FAILURE``, a number of rounds, or why it did not begin.
        seconds: Simulated time [s].
        travelled: Whether the arm moved.
    """

    path: Path
    lacks: tuple[str, ...] = ()
    robot: str = ""
    outcome: str = ""
    seconds: float = 0.0
    travelled: bool = False


class Workspace:
    """The objectives of a folder, by the folder that they are in.

    Args:
        root: The folder.
        parts: The registered parts.

    Raises:
        BtManipError: If there are no objectives.
    """

    def __init__(self, root: Path, parts: Parts) -> None:
        self.root, self.parts = root, parts
        self.folders = sorted(path for path in root.rglob("objectives") if path.is_dir())
        if not self.folders:
            raise BtManipError(f"{root}: there is no folder 'objectives' in it")
        self._libraries = Libraries()

    def objectives(self, folder: Path) -> list[Path]:
        """Return the files with trees in a folder of objectives."""
        paths = sorted(folder.rglob("*.xml"))
        return [path for path in paths if b"<BehaviorTree" in path.read_bytes()]

    def reading(self, folder: Path) -> ReadingOptions:
        """Return how objectives of a folder are read: with the trees of all, its own first."""
        near = sorted(self.folders, key=lambda other: -len(os.path.commonpath((folder, other))))
        libraries = self._libraries.extended(tuple(near))  # each file is parsed once
        return ReadingOptions(dialect="moveit-pro", libraries=libraries, strict=False)

    def waypoints(self, folder: Path) -> Mapping[str, Any]:
        """Return the waypoints beside a folder of objectives."""
        found: dict[str, Any] = {}
        for path in sorted((folder.parent / "waypoints").glob("*.yaml")):
            found |= load_configurations(path)
        return found

    def check(self, path: Path, reading: ReadingOptions) -> Result:
        """Return the result for an objective: the leaves and sub-trees that it lacks."""
        found = read_tree(path, known_behaviours(self.parts), reading)
        lacks: dict[str, None] = {}
        for problem in found.errors:
            unknown = UNKNOWN.match(problem.message)
            lacks[unknown[1] if unknown else problem.message] = None
        return Result(path.relative_to(self.root), tuple(lacks))


def robot_of(waypoints: Mapping[str, Any], joints: Mapping[str, Sequence[str]]) -> str:
    """Return the robot whose joints the waypoints name; empty for none.

    Args:
        waypoints: The waypoints by name.
        joints: Names of joints by robot.
    """
    for robot, names in joints.items():
        for positions in waypoints.values():
            with contextlib.suppress(ValueError):
                if isinstance(positions, Mapping):
                    JointState(positions).configuration(names, "first", "left")
                    return robot
    return ""


class _Watch:
    """Counts rounds of the endless loops of a run, and notes whether an arm moves."""

    def __init__(self, run: Run) -> None:
        self._station = run.station
        self._q = {name: one.arm.q.copy() for name, one in run.station.robots.items()}
        self.rounds = 0
        self.travelled = False
        self._bodies = {
            id(node.children[0])
            for node in run.tree.nodes
            if isinstance(node, KeepRunningUntilFailure)
            or (isinstance(node, Repeat) and node.given.get("num_cycles") == "-1")
        }
        if isinstance(run.tree.root, Node):
            run.tree.root.runtime.observers.append(self._observe)

    def _observe(self, node: Any, old: NodeStatus, new: NodeStatus) -> None:
        self.rounds += id(node) in self._bodies and new is NodeStatus.SUCCESS

    def stop(self) -> bool:
        """Look at the arms; return whether the run ends. It is called before each tick."""
        robots = self._station.robots
        moved = (abs(robots[name].arm.q - q).max() > 0.01 for name, q in self._q.items())
        self.travelled = self.travelled or any(moved)
        return self.rounds >= ROUNDS or self._station.cell.time > SECONDS


def run_objective(path: Path, robot: str, workspace: Workspace) -> Result:
    """Run an objective with the waypoints of its folder, alone in a cell.

    Args:
        path: The file.
        robot: The robot.
        workspace: The workspace that it is in.

    Raises:
        BtManipError: If it cannot begin.
    """
    folder = next(parent for parent in path.parents if parent in workspace.folders)
    request = RunRequest(
        find_tree(str(path.resolve()), {}),
        robot=robot,
        scene=str(SCENE),
        configurations=workspace.waypoints(folder),
        reading=workspace.reading(folder),
    )
    with contextlib.chdir(path.parent):  # where it looks for files
        run = prepare(request, workspace.parts)
        watch = _Watch(run)
        with RunLoop(run) as loop:
            ended = loop.cycle(stop=watch.stop)
    if ended is not None:
        outcome = "SUCCESS" if ended.succeeded else f"FAILURE: {ended.reason}"
    elif watch.rounds >= ROUNDS:
        outcome = f"{watch.rounds} rounds"
    else:
        outcome = f"still running after {SECONDS:g} s"
    name, time = path.relative_to(workspace.root), run.station.cell.time
    return Result(name, (), robot, outcome, time, watch.travelled)


def survey(workspace: Workspace, *, run: bool, only: str = "") -> Iterator[Result]:
    """Yield a result for each objective.

    Args:
        workspace: The workspace.
        run: Whether those that have all leaves run, on a robot that their waypoints fit.
        only: Part of the paths of the objectives that count.
    """
    joints = {
        name: workspace.parts.robots.get(name).arm_joints
        for name in ROBOTS
        if name in workspace.parts.robots
    }
    for folder in workspace.folders:
        paths = [path for path in workspace.objectives(folder) if only in str(path)]
        robot = robot_of(workspace.waypoints(folder), joints) if run and paths else ""
        reading = workspace.reading(folder)
        for path in paths:
            result = workspace.check(path, reading)
            if robot and not result.lacks:
                try:
                    result = run_objective(path, robot, workspace)
                except BtManipError as error:
                    result = Result(result.path, (), robot, f"before the run: {error}")
            yield result


def table_row(result: Result) -> str:
    """Return a row of the table, in Markdown."""
    more = len(result.lacks) - SHOWN
    lacks = ", ".join(result.lacks[:SHOWN]) + (f" and {more} more" if more > 0 else "") or "-"
    seconds = f"{result.seconds:.1f}" if result.outcome and result.seconds else ""
    outcome = result.outcome.replace("|", "/").partition("\n")[0]
    cells = (str(result.path), lacks, result.robot, outcome, seconds)
    return f"| {' | '.join(cells)} |"


HEADER = (
    "| objective | lacks | robot | result | time [s] |\n"
    "|-----------|-------|-------|--------|----------|"
)


def summary(results: Sequence[Result]) -> str:
    """Return the numbers of a table in a sentence."""
    complete = [result for result in results if not result.lacks]
    ended = [r for r in complete if r.outcome == "SUCCESS" or r.outcome.endswith("rounds")]
    moved = [result for result in ended if result.travelled]
    text = f"{len(complete)} of {len(results)} objectives have all leaves and sub-trees"
    if any(result.outcome for result in results):
        text += f"; {len(ended)} run to their end, {len(moved)} of these move an arm"
    return text + "."
