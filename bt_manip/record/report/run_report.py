"""Report of a run, as plain values and as JSON."""

import importlib.metadata
import json
import math
import platform
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from bt_manip.exceptions import without_numbers

REPORTED_PACKAGES = (
    "bt-manip", "mujoco", "dm-control", "pin", "ruckig", "py_trees", "numpy",
)  # fmt: skip
"""Packages on which the states of a run depend, beside tree and seed."""

REASONS = 3
"""Number of reasons that are listed why leaves did not run, the most frequent ones."""


@dataclass(frozen=True)
class Phase:
    """One action leaf from its start to its end.

    Attributes:
        behaviour: Registered name of its class.
        name: Its name in the tree.
        status: ``"SUCCESS"``, ``"FAILURE"``, or ``"HALTED"``.
        reason: Reason of a failure.
        start_s: Simulated time since the start of the cycle [s].
        duration_s: Simulated time that it took [s].
    """

    behaviour: str
    name: str
    status: str
    reason: str
    start_s: float
    duration_s: float


@dataclass(frozen=True)
class CycleLimitUse:
    """The largest fraction of each kind of limit that a joint used; 1.0 is the limit itself.

    Position, velocity, acceleration and jerk are those of the reference; effort is the commanded
    torque. The position is measured from the centre of a joint's range.
    """

    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0
    effort: float = 0.0


@dataclass(frozen=True)
class TrackingPeak:
    """The largest tracking error of a cycle in free motion: where it was, and what preceded it.

    Attributes:
        joint: Name of the joint in its robot's description.
        leaf: Name of the action leaf that ran, the one that started last; empty without any.
        time_s: Simulated time since the start of the cycle [s].
        effort: Largest fraction of its effort limit that a joint of the arm used in the 100 ms
            before; at 1.0 a motor was saturated.
        after_contact_s: Time since gripper or payload last touched anything else [s]; None after
            more than 100 ms. What a contact carried is released when it ends.
    """

    joint: str
    leaf: str
    time_s: float
    effort: float
    after_contact_s: float | None = None


@dataclass(frozen=True)
class RobotCycle:
    """Figures of one of several robots in a cycle.

    Attributes:
        picked: Names of the objects that it gripped.
        grip_force_n: Least of the gripper's forces at the end of the last Grasp that held an
            object, whether it succeeded or not [N], or None.
        max_tracking_error_rad: Largest difference between a joint and its reference while the
            reference moved and no robot touched anything but its held object, or None [rad].
        tracking_peak: Time, joint and possible causes of that error.
        max_deflection_rad: Largest difference at all other times, as while gripping [rad].
        limits: Largest fractions of limits used.
        saturated_steps: Control steps in which an effort was clipped to its limit.
        max_torque_rate_nm_s: Largest change of a joint's torque [N m/s].
        max_tool_speed_m_s: Largest speed of the tool's origin [m/s].
    """

    picked: tuple[str, ...] = ()
    grip_force_n: float | None = None
    max_tracking_error_rad: float | None = None
    tracking_peak: TrackingPeak | None = None
    max_deflection_rad: float = 0.0
    limits: CycleLimitUse = field(default_factory=CycleLimitUse)
    saturated_steps: int = 0
    max_torque_rate_nm_s: float = 0.0
    max_tool_speed_m_s: float = 0.0


@dataclass(frozen=True)
class GrippedObject:
    """An object that was gripped in a cycle.

    Attributes:
        name: Its name in the cell.
        placed: Whether it lay where the goal wants it, at rest and released, in the step before it
            was removed, or else at the end of the cycle; None if the goal names no destination of
            it.
        robot: Name of the robot that gripped it last.
    """

    name: str
    placed: bool | None
    robot: str


@dataclass(frozen=True)
class LeafTime:
    """How long the leaves of a class ran in a cycle that declares `reports_time`.

    Attributes:
        share: Share of the cycle's duration, 0 to 1.
        reasons: Why they did not run, or not longer: reasons of failures, or that none was ticked.
    """

    share: float = 0.0
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True)
class CycleReport:
    """One run of the root from idle to SUCCESS or FAILURE.

    Attributes:
        status: ``"SUCCESS"`` or ``"FAILURE"``; ``"INTERRUPTED"`` or ``"ERROR"`` for a cycle
            that did not end.
        reason: Reason of a failure, with the path of the node.
        goal: Whether the goal that the tree declares holds in the physics; None if it declares
            none. A cycle whose goal does not hold has failed.
        goal_reason: Why the goal does not hold.
        judged_by: ``"physics"``, ``"gripper and assumption"`` on a real robot, or ``"tree"`` where
            no condition of a goal reads the cell, so that the tree alone decides whether the cycle
            succeeded.
        object: Name of the object that was gripped, or None if none or several were.
        placed: Whether all `objects` with a destination in the goal are placed; None if there are
            none.
        objects: The objects that were gripped, in this order.
        duration_s: Simulated time that it took [s].
        phases: The action leaves, in the order of their ends.
        grip_force_n: Least of the gripper's forces at the end of the last Grasp that held an
            object, whether it succeeded or not [N], or None.
        max_tracking_error_rad: Largest difference between a joint and its reference while the
            reference moved and gripper and payload touched only each other, or None [rad].
        tracking_peak: Time, joint and possible causes of that error.
        max_deflection_rad: Largest difference at all other times, as while gripping [rad].
        limits: Largest fractions of limits used.
        saturated_steps: Control steps in which an effort was clipped to its limit.
        unexpected_contacts: Pairs of names of unexpected contacts.
        max_torque_rate_nm_s: Largest change of a joint's torque [N m/s].
        max_tool_speed_m_s: Largest speed of the tool's origin [m/s].
        randomized: Sampled values, by kind, name and quantity.
        leaf_times: How long leaves ran that declare `reports_time`, such as learned policies, by
            registered name.
        drawn: Values that nodes drew, by path and output; of each, those of the last time it
            succeeded. Poses are positions and rotation vectors, by axis.
        retries: How often the child of a `RetryUntilSuccessful` was started again, by path.
        rescues: How often a fallback succeeded after an action in an earlier child failed, by path.
        results: Values of the tree's results, by key; null where nothing was written.
        robots: With several robots, the figures of each by name; the figures above are then
            maxima or sums.
    """

    status: str
    reason: str = ""
    goal: bool | None = None
    goal_reason: str = ""
    judged_by: str = "physics"
    object: str | None = None
    placed: bool | None = None
    objects: tuple[GrippedObject, ...] = ()
    duration_s: float = 0.0
    phases: tuple[Phase, ...] = ()
    grip_force_n: float | None = None
    max_tracking_error_rad: float | None = None
    tracking_peak: TrackingPeak | None = None
    max_deflection_rad: float = 0.0
    limits: CycleLimitUse = field(default_factory=CycleLimitUse)
    saturated_steps: int = 0
    unexpected_contacts: tuple[tuple[str, str], ...] = ()
    max_torque_rate_nm_s: float = 0.0
    max_tool_speed_m_s: float = 0.0
    randomized: dict[str, dict[str, dict[str, Any]]] = field(default_factory=dict)
    leaf_times: dict[str, LeafTime] = field(default_factory=dict)
    drawn: dict[str, dict[str, Any]] = field(default_factory=dict)
    retries: dict[str, int] = field(default_factory=dict)
    rescues: dict[str, int] = field(default_factory=dict)
    results: dict[str, Any] = field(default_factory=dict)
    robots: dict[str, RobotCycle] = field(default_factory=dict)


@dataclass(frozen=True)
class RunReport:
    """A whole run.

    Attributes:
        tree: The tree as the user named it.
        seed: Seed of all randomness.
        status: ``"SUCCESS"``, ``"FAILURE"`` when any cycle failed, ``"INTERRUPTED"``,
            ``"ERROR"``, or ``"RUNNING"`` in the file of a run that goes on or was killed;
            `read_report` tells these apart.
        cycles: Its cycles, in order.
        simulated_s: Simulated time [s].
        wall_s: Wall time [s].
        real_time_factor: Simulated time over wall time.
        state_digest: SHA-256 over the states and node statuses after every tick.
        versions: Versions of the packages that the run depends on.
        error: Reason of the status ``"ERROR"``, with the plugin that raised.
        ended_early: Why it ended before its last cycle without an error; empty where it did not.
        warnings: What is strange in the model files: impossible inertias, invented masses.
        robot: Robot, by registered name or file; several names where the scene's robots differ.
        scene: Scene, by registered name or file.
        controller: Controller that each cycle begins with; several as for `robot`.
        planner: Planner; several as for `robot`.
        settings: Settings of the tree that were given, by key.
        tick_s: Simulated time between two ticks of the tree [s].
        time_step_s: Time between two control steps [s].
        modifiers: Texts of each modifier, as given after ``--NAME``, by its name: ``fault``.
        plugins: Version of each loaded plugin, by name.
        foreign: Options for trees of others, where any were given.
        varied: Parameters that were set as a sweep varies them, by name.
        agent: Kind of the actions of an agent that acted in place of the tree; empty without one.
        episode: Number of the episode that was run instead of cycles.
        sha256: SHA-256 of the files that were read for the run, by name without folder: of the tree
            and what it includes, scene, robot, models and so on. ``files of NAME`` are the meshes
            and textures of a model together; of several of one name there are several.
        modules: SHA-256 of the Python modules of no installed package that were imported, by name.
        speed: Factor of all speeds of the arm.
        tool_speed: Limit of the speed of the tool that was given [m/s].
        poses: Source of the objects' poses.
        real: On a real robot: ``backend``, ``late_ticks``, ``lost_cycles``, ``longest_gap_s``
            between two cycles, ``assumed`` objects, whose poses nobody has measured since they were
            released, and what the device says. Empty in simulation.
    """

    tree: str
    seed: int
    status: str
    cycles: tuple[CycleReport, ...] = ()
    simulated_s: float = 0.0
    wall_s: float = 0.0
    real_time_factor: float = 0.0
    state_digest: str = ""
    versions: dict[str, str] = field(default_factory=dict)
    error: str = ""
    ended_early: str = ""
    warnings: tuple[str, ...] = ()
    robot: str = ""
    scene: str = ""
    controller: str = ""
    planner: str = ""
    settings: dict[str, str] = field(default_factory=dict)
    tick_s: float | None = None
    time_step_s: float | None = None
    modifiers: dict[str, tuple[str, ...]] = field(default_factory=dict)
    plugins: dict[str, str] = field(default_factory=dict)
    foreign: dict[str, Any] = field(default_factory=dict)
    varied: dict[str, Any] = field(default_factory=dict)
    agent: str = ""
    episode: int | None = None
    sha256: dict[str, str] = field(default_factory=dict)
    modules: dict[str, str] = field(default_factory=dict)
    speed: float = 1.0
    tool_speed: float | None = None
    poses: str = "physics"
    real: dict[str, Any] = field(default_factory=dict)

    def plain(self) -> dict[str, Any]:
        """Return the report as types of JSON; non-finite numbers become None.

        Cycles of a single robot have no `robots`.
        """
        content = plain(replace(self, cycles=()))
        return content | {"cycles": [plain_cycle(cycle) for cycle in self.cycles]}

    def to_json(self) -> str:
        """Return the report as JSON."""
        return json.dumps(self.plain(), indent=2, allow_nan=False) + "\n"


def plain_cycle(cycle: CycleReport) -> dict[str, Any]:
    """Convert a cycle to types of JSON; `robots` is left out where there is only one."""
    content = plain(cycle)
    if not cycle.robots:
        del content["robots"]
    return content


class LeafUse:
    """In how many cycles or episodes leaves ran, for which share of the time, and why not."""

    def __init__(self) -> None:
        self._names: dict[str, list[float]] = {}  # cycles, those in which it ran, time ran, time
        self._reasons: dict[str, dict[str, tuple[str, int]]] = {}  # by name and text

    def add(self, times: Mapping[str, LeafTime], duration: float) -> None:
        """Count a cycle of a duration [s], with its `CycleReport.leaf_times`."""
        for name, one in times.items():
            counted = self._names.setdefault(name, [0, 0, 0.0, 0.0])
            added = (1, one.share > 0.0, one.share * duration, duration)
            counted[:] = map(sum, zip(counted, added, strict=True))
            known = self._reasons.setdefault(name, {})
            for reason in one.reasons:
                key = without_numbers(reason)
                text, count = known.get(key, (reason, 0))
                known[key] = text, count + 1

    def sentences(self, cycles: str) -> list[str]:
        """Return a sentence for each registered name; ``cycles`` or ``episodes`` were counted."""
        found = []
        for name, (count, ran, time, total) in self._names.items():
            share = time / total if total else 0.0
            line = f"{name} ran in {ran:.0f} of {count:.0f} {cycles}, for {share:.1%} of the time"
            reasons = sorted(self._reasons[name].values(), key=lambda one: -one[1])[:REASONS]
            why = "; ".join(f"{n} x {text}" for text, n in reasons)
            found.append(f"{line}: {why}." if why else f"{line}.")
        return found


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that a run depends on."""
    found = {"python": platform.python_version()}
    for name in REPORTED_PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "unknown"
    return found


@cache
def cpu_name() -> str:
    """Return the model of the processor, on which the last bits of a run depend."""
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()


def plain(value: Any) -> Any:
    """Convert a value to types of JSON: dataclasses to objects, non-finite numbers to None."""
    if is_dataclass(value):
        return {key: plain(item) for key, item in vars(value).items()}
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
