"""Quantities over time that the page plots: of a run, or of a recording."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import takewhile
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from bt_manip.runner import Run, RunEvent
from bt_manip_view.html.thinning import SAMPLES, thin
from bt_manip_view.page.gui import is_number

if TYPE_CHECKING:
    from bt_manip_recording import Recording, Timeline

MAX_TICKS = 6000
"""Number of ticks of a run that are kept: a minute, at the usual 10 ms."""

SAME_HEIGHT = 1e-3
"""Range of the height of a recorded object that counts as at rest [m]."""

TRACKING_ERROR, POSITIONS = "Tracking error", "Joint positions"
HEIGHTS = "Height of objects"
WRIST = (("Wrist force", "N"), ("Wrist torque", "N m"))


class Table(NamedTuple):
    """Values of a quantity over time."""

    unit: str
    labels: tuple[str, ...]
    """Names of the values of a row."""
    rows: np.ndarray
    """Simulated time [s], then the values; NaN where there is none.  # (n, 1 + labels)"""


class LiveQuantities:
    """Quantities of a run, sampled after each tick, by name in the order in which they are offered.

    Args:
        run: The run.
        clock: Returns its simulated time [s].
    """

    def __init__(self, run: Run, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._cell, robots = run.station.cell, run.station.robots
        self._units: dict[str, str] = {}
        self._labels: dict[str, dict[str, None]] = {}  # all labels so far
        self._rows: dict[str, deque[tuple[float, Sequence[str], Any]]] = {}
        self._readers: list[tuple[Sequence[str], Sequence[str], Callable[[], Iterable[Any]]]] = []
        self._numbers: dict[str, float] = {}  # of the blackboard
        self._joints = {name: one.robot.description.arm_joints for name, one in robots.items()}
        self._offer(TRACKING_ERROR, "mrad")
        for name, one in robots.items():
            self._read_robot(one, f" of {name}" if len(robots) > 1 else "", run)
        self._offer(HEIGHTS, "m")

    def _read_robot(self, one: Any, of: str, run: Run) -> None:
        """Add the quantities of a robot."""
        robot, gripper, joints = one.robot, one.gripper, one.robot.description.arm_joints
        self._offer(f"{POSITIONS}{of}", "rad")
        self._read({f"Joint velocities{of}": "rad/s"}, joints, lambda: [robot.v])
        self._read({f"Joint torques{of}": "N m"}, joints, lambda: [one.controller.tau.copy()])
        if gripper is not None:
            fingers = [f"finger {i + 1}" for i in range(len(gripper.forces))]
            self._read({f"Grip force{of}": "N"}, fingers, lambda: [gripper.forces])
        if not run.request.backend:  # a simulated wrench means nothing for a real arm
            wrench = {f"{name}{of}": unit for name, unit in WRIST}
            self._read(wrench, ("x", "y", "z"), robot.wrist_wrench)

    def names(self) -> list[str]:
        """Return the names of all quantities."""
        return list(self._rows)

    def table(self, name: str, after: float = -np.inf) -> Table:
        """Return the values of a quantity after a simulated time [s]."""
        rows = list(takewhile(lambda row: row[0] > after, reversed(self._rows[name])))[::-1]
        labels = tuple(self._labels[name])
        column = {label: i for i, label in enumerate(labels, 1)}
        values = np.full((len(rows), 1 + len(labels)), np.nan)
        for row, (time, some, numbers) in zip(values, rows, strict=True):
            row[0] = time
            row[[column[label] for label in some]] = numbers
        return Table(self._units[name], labels, values)

    def handle(self, event: RunEvent) -> None:
        """Store a number of the blackboard."""
        if event.kind == "blackboard":
            key, value = event.data["key"], event.data["value"]
            if is_number(value):
                self._numbers[key] = value
            else:
                self._numbers.pop(key, None)

    def sample(self) -> None:
        """Store the values after a tick."""
        time, cell = self._clock(), self._cell
        for names, labels, read in self._readers:
            for name, values in zip(names, read(), strict=True):
                self._add(name, time, labels, values)
        if free := [name for name in cell.objects if cell.is_free(name)]:
            self._add(HEIGHTS, time, free, cell.data.xpos[[*map(cell.body_id, free)], 2])
        for key, number in self._numbers.items():
            self._add(f"Blackboard {key}", time, (key,), [number])

    def add_joints(
        self, times: np.ndarray, joints: Mapping[str, tuple[np.ndarray, np.ndarray]]
    ) -> None:
        """Store positions and tracking errors after some ticks, as `Panel.sample` gets them."""
        several, robots = len(joints) > 1, tuple(joints)
        errors = [1e3 * np.abs(q - q_ref).max(axis=1) for q, q_ref in joints.values()]
        for i, time in enumerate(times.tolist()):
            self._add(TRACKING_ERROR, time, robots, [error[i] for error in errors])
            for name, (q, _) in joints.items():
                of = f" of {name}" if several else ""
                self._add(f"{POSITIONS}{of}", time, self._joints[name], q[i])

    def _offer(self, name: str, unit: str) -> None:
        self._units[name], self._labels[name] = unit, {}
        self._rows[name] = deque(maxlen=MAX_TICKS)

    def _read(
        self, units: dict[str, str], labels: Sequence[str], read: Callable[[], Iterable[Any]]
    ) -> None:
        """Add quantities, by name, whose values ``read`` returns."""
        self._readers.append((tuple(units), labels, read))
        for name, unit in units.items():
            self._offer(name, unit)

    def _add(self, name: str, time: float, labels: Sequence[str], values: Any) -> None:
        if name not in self._rows:
            self._offer(name, "")
        self._labels[name].update(dict.fromkeys(labels))
        self._rows[name].append((time, labels, values))


class RecordedQuantities:
    """Quantities of a recording; each is read when it is asked for.

    Args:
        recording: The recording.
        timeline: Its ticks.
    """

    def __init__(self, recording: "Recording", timeline: "Timeline") -> None:
        self._recording, self._timeline = recording, timeline
        self._read: dict[str, Callable[[], Table]] = {TRACKING_ERROR: self._errors}
        for robot in recording.joints:
            of = f" of {robot}" if len(recording.joints) > 1 else ""
            for name, field, unit in (
                (POSITIONS, "q", "rad"),
                ("Joint velocities", "v", "rad/s"),
                ("Joint torques", "tau", "N m"),
            ):
                self._read[f"{name}{of}"] = partial(self._steps, robot, field, unit)
            if f"/robots/{robot}/state" in recording.topics:
                for name, unit, key, labels in (
                    ("Grip force", "N", "grip_forces", ()),
                    ("Wrist force", "N", "force", ("x", "y", "z")),
                    ("Wrist torque", "N m", "torque", ("x", "y", "z")),
                ):
                    self._read[f"{name}{of}"] = partial(self._states, robot, key, unit, labels)
        self._read[HEIGHTS] = self._heights
        with recording.decoding():
            for event in recording.events("blackboard"):
                if is_number(event.data["value"]):
                    key = event.data["key"]
                    self._read[f"Blackboard {key}"] = partial(self._numbers, key)
        self._tables: dict[str, Table] = {}

    def names(self) -> list[str]:
        """Return the names of all quantities."""
        return list(self._read)

    def table(self, name: str, after: float = -np.inf) -> Table:
        """Return the values of a quantity after a simulated time [s]."""
        if name not in self._tables:
            unit, labels, rows = self._read[name]()
            self._tables[name] = Table(unit, labels, thin(rows))
        unit, labels, rows = self._tables[name]
        return Table(unit, labels, rows[rows[:, 0] > after])

    def _errors(self) -> Table:
        times, joints = self._timeline.joints(1, len(self._timeline.times))
        errors = [1e3 * np.abs(q - q_ref).max(axis=1) for q, q_ref in joints.values()]
        return Table("mrad", tuple(joints), np.column_stack([times, *errors]))

    def _steps(self, robot: str, field: str, unit: str) -> Table:
        steps = self._recording.control_steps(robot)
        rows = np.column_stack([steps["t"], steps[field]])
        return Table(unit, tuple(self._recording.joints[robot]), rows)

    def _states(self, robot: str, key: str, unit: str, labels: tuple[str, ...]) -> Table:
        """Return a number or numbers of the states; those without labels are of the fingers."""
        found = list(self._recording.messages(f"/robots/{robot}/state"))
        if not found:
            return Table(unit, labels, np.empty((0, 1 + len(labels))))
        rows = np.array([[time, *np.atleast_1d(state[key])] for time, _, state in found])
        count = rows.shape[1] - 1
        return Table(unit, labels or tuple(f"finger {i + 1}" for i in range(count)), rows)

    def _heights(self) -> Table:
        """Return the heights of the objects that move."""
        scene = self._timeline.scene
        robots, before = set(self._recording.joints), scene.index
        names = {event.data["name"] for event in self._recording.events("entity")} - robots
        roots: dict[str, int] = {}  # frame of the first body of each object
        for i, frame in enumerate(scene.frames):
            if (name := frame.partition("/")[0]) in names:
                roots.setdefault(name, i)
        count = len(scene.times)
        ticks = np.unique(np.linspace(0, count - 1, min(count, SAMPLES)).astype(int))
        rows = np.full((len(ticks), 1 + len(roots)), np.nan)
        for row, index in zip(rows, ticks.tolist(), strict=True):
            scene.index = index
            poses, present = scene.poses(), scene.entities()
            values = [poses[i, 2] if name in present else np.nan for name, i in roots.items()]
            row[:] = scene.times[index], *values
        scene.index = before
        heights = rows[:, 1:]
        lowest = np.nanmin(heights, axis=0, initial=np.inf)
        moving = np.nanmax(heights, axis=0, initial=-np.inf) - lowest > SAME_HEIGHT
        labels = tuple(name for name, moves in zip(roots, moving, strict=True) if moves)
        return Table("m", labels, rows[:, [True, *moving]])

    def _numbers(self, key: str) -> Table:
        """Return the values of an entry of the blackboard, as steps."""
        rows: list[tuple[float, float]] = []
        for event in self._recording.events("blackboard"):
            if event.data["key"] == key:
                value = event.data["value"]
                number = float(value) if is_number(value) else np.nan
                if rows:
                    rows.append((event.time, rows[-1][1]))
                rows.append((event.time, number))
        rows.append((float(self._timeline.times[-1]), rows[-1][1]))
        return Table("", (key,), np.array(rows))
