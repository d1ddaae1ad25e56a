"""Trial of a described robot in pick, lift and place cycles."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip import build_station
from bt_manip.behaviours import (
    ArmBehaviour,
    Grasp,
    Hover,
    Lift,
    OpenGripper,
    PlaceAt,
    Reach,
    SpawnObject,
)
from bt_manip.bt import NodeStatus, Sequence
from bt_manip.cell import Region
from bt_manip.cell.objects import Box
from bt_manip.exceptions import BtManipError, without_numbers
from bt_manip.registry import Parts
from bt_manip.robots import Robot, RobotDescription
from bt_manip.runner import RunObserver, Station, prepare, request_of
from bt_manip.scenes import table_and_basket

from .inspection import tool_findings

if TYPE_CHECKING:
    from bt_manip.bt import Node
    from bt_manip.runner import Run


CYCLES = 20
"""Cycles of the task in a trial."""

_TASK = "pick_place"
_SEED = 1  # differs from the default of a run
_MAX_FAILED = 3  # failed cycles after which the trial ends
_RETRIED_SHARE = 0.25  # share of cycles with a retry above which it is a finding
_TRACKING = 1e-2  # [rad] or [m] largest tracking error in free motion
_CUBE, _POST_NAME = "cube", "post"
_POST = (0.02, 0.02, 0.06)  # [m] size of the post on which a cube stands in the air
_APART = 0.1  # [m] least distance of the place pose from the post
_GRASP_TIMEOUT = 60.0  # [s] longest simulated time of the grasp on the post

_REMEDIES = (
    ("no steady grip", "gripper", "check its joints, fingers, motor, pads and max_force"),
    ("closed without gripping", "gripper", "check its fingers and max_force, and the tool frame"),
    ("the gripper holds", "gripper", "check its fingers, and the tool frame"),
    ("too little friction", "gripper.max_force", "give more, if the gripper has it"),
    ("was lost", "gripper", "check its max_force, pads and fingers"),
    ("is not open", "gripper", "check its open_width, joints, motor and frictionloss"),
    ("gripper.", "gripper", "check its keys"),
    ("N m to hold", "effort", "give more, if the arm has it, or less to carry"),
    ("Lift: external force", "gripper", "check its pads and fingers, then effort and armature"),
    ("to follow", "armature", "give more, and check acceleration and effort"),
    ("external force", "armature", "check it, and effort and acceleration"),
    ("mm inside", "base", "move or raise it"),
    ("clearance", "tool", "check its position and axes; z is the direction of approach"),
    ("would touch", "base", "change position or pedestal, and check exclude and the tool frame"),
    ("reach", "base", "change position or pedestal, and check the tool frame"),
)
"""Words in the reason of a failure, the key that causes it, and the remedy."""


class Checked(NamedTuple):
    """Result of the checks of a description, or of a trial.

    Attributes:
        findings: Problems, one line each, with key and remedy.
        facts: Measured figures, one line each.
        robot: The robot, compiled alone; None after a trial, or if it cannot be built.
    """

    findings: list[str]
    facts: list[str]
    robot: Robot | None = None


def try_robot(
    description: RobotDescription,
    parts: Parts,
    cycles: int = CYCLES,
    report: Callable[[str], None] = lambda _: None,
) -> Checked:
    """Let a robot grasp a cube from a post and place it, then run the pick and place task.

    Behaviours, station and task are those of a run. Findings about the tool frame come first.

    Args:
        description: The robot, with a gripper.
        parts: The registered parts.
        cycles: Number of cycles of the task.
        report: Called with the present step of the trial.
    """
    where = description.where
    watch = TrialWatch(lambda n: report(f"{_TASK}: cycle {n} of {cycles}"))
    try:
        whole = table_and_basket()
        table = replace(whole, objects=tuple(f for f in whole.objects if f.name == "table"))
        report("a cube on a post")
        air = _grasp_in_the_air(build_station(parts, robot=description, scene=table))
        request = request_of(_TASK, parts, robot=description, cycles=cycles, seed=_SEED)
        run = prepare(request, parts)
        run.execute([watch], stop=lambda: watch.failed >= _MAX_FAILED)
    except BtManipError as error:
        reason = _finding(where, "the pick and place task", str(error))
        return Checked([*tool_findings(description), reason], [])
    findings = [_finding(where, "a cube on a post", air)] if air else []
    findings += watch.findings(where)
    if findings:
        findings = [*tool_findings(description), *findings]
    done = watch.cycles
    facts = [
        f"{_TASK}: {done - watch.failed} of {done} cycles, {watch.retried} of them with a retry",
        f"tracking error: {1e3 * watch.error:.2g} mrad at most",
    ]
    return Checked(findings, facts)


def _grasp_in_the_air(station: Station) -> str:
    """Grasp a cube on a slender post, lift it, set it on the table; return the failure."""
    cell = station.cell
    area = station.first.reach.area(cell, "table", _POST[2])
    (x, y), (u, v) = _two_places(area, station.robot.tool_pose.translation[:2])
    top = cell.surface_height("table")
    post = pin.SE3(np.eye(3), np.array([x, y, top + 0.5 * _POST[2]]))
    cell.add(_Post(size=_POST), post, name=_POST_NAME, free=False)
    tree = Sequence(
        SpawnObject(on=_POST_NAME, region=_text(x, x, y, y), name_hint=_CUBE),
        OpenGripper(),
        Hover(object=_CUBE),
        Reach(object=_CUBE),
        Grasp(object=_CUBE),
        Lift(height=0.05),
        PlaceAt(object=_CUBE, pose=_text(u, v, top, 1.0, 0.0, 0.0, 0.0)),
    )
    try:
        return station.run(tree, timeout=_GRASP_TIMEOUT).reason
    except TimeoutError as error:
        return str(error)


def _two_places(area: Region, near: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the point of an area nearest to a given point, and a second one beside it [m]."""
    grid = [(x, y) for y in np.linspace(*area.y, 5) for x in np.linspace(*area.x, 5)]
    points = np.array(area.squares or grid)
    first = points[np.linalg.norm(points - near, axis=1).argmin()]
    distance = np.linalg.norm(points - first, axis=1)
    return first, points[np.where(distance < _APART, np.inf, distance).argmin()]


def _text(*numbers: float) -> str:
    return ";".join(f"{number:.6g}" for number in numbers)


class _Post(Box):
    """A slender box on which a cube stands."""

    kind = "post"

    @property
    def surface_height(self) -> float:
        """Height of the top above the origin [m]."""
        return 0.5 * _POST[2]


class TrialWatch(RunObserver):
    """Collects failures of arm behaviours, and the largest tracking error in free motion."""

    def __init__(self, begin: Callable[[int], None]) -> None:
        self._begin = begin
        self.cycles = self.failed = self.retried = 0  # retried: succeeded after a failed action
        self.error, self.joint = 0.0, ""  # [rad] or [m]
        self._reasons: Counter[str] = Counter()
        self._examples: dict[str, str] = {}
        self._in_cycle: list[str] = []

    def run_started(self, run: "Run") -> None:
        """Store the robot, and observe the nodes of the tree."""
        self._cell, self._robot = run.station.cell, run.station.first
        run.tree.observers.append(self.node_changed)

    def cycle_started(self, cycle: int) -> None:
        """Clear the failures of the last cycle, and report the new one."""
        self._in_cycle = []
        self._begin(cycle + 1)

    def node_changed(self, node: "Node", old: NodeStatus, new: NodeStatus) -> None:
        """Note the reason of an arm behaviour that has failed."""
        if new is NodeStatus.FAILURE and isinstance(node, ArmBehaviour):
            self._in_cycle.append(f"{node.name}: {node.feedback_message}")

    def after_tick(self) -> None:
        """Measure the tracking error."""
        arm, robot = self._robot.arm, self._robot.robot
        if arm.moving and self._cell.contact_monitor.summary().free:
            errors = np.abs(robot.q - arm.q_ref)
            if errors.max() > self.error:
                self.error = float(errors.max())
                self.joint = robot.description.arm_joints[int(errors.argmax())]

    def cycle_ended(self, status: str, reason: str) -> None:
        """Count the cycle."""
        self.cycles += 1
        succeeded = status == "SUCCESS"
        self.failed += not succeeded
        self.retried += succeeded and bool(self._in_cycle)
        for first in [*self._in_cycle, *([] if succeeded else [reason])][:1]:
            kind = without_numbers(first, "...")
            self._reasons[kind] += 1
            self._examples.setdefault(kind, first)

    def findings(self, where: str) -> Iterator[str]:
        """Yield failures and excessive tracking errors."""
        if self.failed or self.retried > _RETRIED_SHARE * self.cycles:
            for kind, count in self._reasons.most_common():
                done = f"{count} of {self.cycles} cycles"
                yield _finding(where, f"{_TASK}, {done}", self._examples[kind])
        if self.error > _TRACKING:
            yield (
                f"{where}: key 'armature': {self.joint} is up to {1e3 * self.error:.0f} mrad from "
                "its reference in free motion; give more, or a smaller acceleration"
            )


def _finding(where: str, what: str, reason: str) -> str:
    """Return a finding about a failure, with the key that may cause it and its remedy."""
    for words, key, remedy in _REMEDIES:
        if words in reason:
            return f"{where}: key '{key}': {what}: {reason}; {remedy}"
    return f"{where}: {what}: {reason}; bt-manip run {_TASK} --robot FILE --view shows it"
