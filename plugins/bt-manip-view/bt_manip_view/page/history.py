"""The past of a run, in memory."""

import copy
import threading
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bt_manip.runner import STEP_FIELDS, RunEvent
from bt_manip_recording import CellScene, SceneCamera, VisualShape

from .scene import shapes_digest

KEPT_BYTES = 200_000_000
"""Memory for the past [bytes]: half an hour of ``pick_place``, a quarter of two arms."""

ITEM_BYTES = 500
"""Estimated memory of an event, and of a state beside its numbers [bytes]."""

TOOL = 3
"""Numbers at the end of a control step: the tool's position [m]."""

Step = tuple[bytes, bool]
"""A row of a `bt_manip.runner.StepLog`, and its ``ContactSummary.free``."""

FORGOTTEN = 0.1
"""Share of the states that are forgotten at once when the memory is full."""

SUBJECTS = "uid", "status", "key", "name", "robot", "kind", "body"
"""Keys of the data of an event that tell what it is about."""


class _Look(NamedTuple):
    """What is in the cell from a state on."""

    first: int
    """Number of the state."""
    places: np.ndarray
    """Indices of its bodies in `History.frames`."""
    entities: dict[str, str]
    """Digests of the shapes by entity."""
    cameras: Sequence[SceneCamera]
    centre: np.ndarray
    extent: float


class History:
    """The states of a run between its ticks, as a `bt_manip_recording.Timeline` of its recording.

    State 0 is that before the first tick, state i that after the i-th tick. When `KEPT_BYTES` are
    used, the oldest states are forgotten; of their events, the last of each kind about the same
    subject stay. As a `bt_manip_recording.SceneSource` it is the scene in the state `index`.

    Attributes:
        first: Number of the first state that is kept.
        times: Simulated times of the kept states [s].
        frames: Names of the frames of all bodies so far.
        index: Number of the state that the scene shows.
        size: Estimated memory of states and events [bytes].
    """

    def __init__(self, kept_bytes: int = KEPT_BYTES) -> None:
        self._kept_bytes, self._lock = kept_bytes, threading.Lock()
        self.first = self.index = self.size = 0
        self.times: list[float] = []
        self.frames: list[str] = []
        self._poses: list[np.ndarray] = []  # (n, 7) each, as of the bodies of its look
        self._steps: list[Mapping[str, Step]] = []
        self._events: list[RunEvent] = []
        self._ends: list[int] = []  # number of kept events before each state's next tick
        self._is_open = False  # further events belong to the last state
        self._looks: list[_Look] = []
        self._present: dict[str, tuple[Any, str]] = {}  # appearance and digest, by entity
        self._shapes: dict[str, Mapping[str, Sequence[VisualShape]]] = {}  # by digest

    # The run

    def look(self, source: CellScene) -> None:
        """Note what is in the cell from the next state on."""
        known = {name: i for i, name in enumerate(self.frames)}
        for name in source.frames:
            if known.setdefault(name, len(known)) == len(self.frames):
                self.frames.append(name)
        before, self._present = self._present, {}
        for name, appearance in source.entities().items():
            same, digest = before.get(name, (None, ""))
            if appearance != same:
                shapes = source.shapes(name)
                digest = shapes_digest(shapes)
                self._shapes.setdefault(digest, shapes)
            self._present[name] = appearance, digest
        places = np.array([known[name] for name in source.frames])
        entities = {name: digest for name, (_, digest) in self._present.items()}
        view = source.cameras, source.centre, source.extent
        self._looks.append(_Look(self.first + len(self.times), places, entities, *view))

    def add(self, event: RunEvent) -> None:
        """Add an event."""
        self._events.append(event)
        self.size += ITEM_BYTES

    def begin_tick(self) -> None:
        """Let further events lead to the next state."""
        if self._is_open:
            self._ends[-1], self._is_open = len(self._events), False

    def end_tick(self, time: float, poses: np.ndarray, steps: Mapping[str, Step]) -> None:
        """Add the state after a tick, or before the first one.

        Args:
            time: Simulated time [s].
            poses: Poses of the bodies of the last `look`, kept as they are.  # (n, 7)
            steps: Last control step of each robot; none before the first tick.
        """
        with self._lock:
            self.begin_tick()
            self.times.append(time)
            self._poses.append(poses)
            self._steps.append(steps)
            self._ends.append(0)
            self._is_open = True
            self.size += _bytes(self._poses[-1], steps)
            if self.size > self._kept_bytes:
                self._forget(int(FORGOTTEN * len(self.times)))

    # The page

    @property
    def scene(self) -> "History":
        """The scene, in the state `index`."""
        return self

    @property
    def last(self) -> int:
        """Number of the last state."""
        return self.first + len(self.times) - 1

    @property
    def time(self) -> float:
        """Simulated time of the state that the scene shows [s]."""
        return self.times[self.index - self.first]

    def seek(self, time: float) -> None:
        """Go to the state after the last tick that ended at or before a time [s]."""
        self.index = self.first + max(bisect_right(self.times, time + 1e-9) - 1, 0)

    def events(self, before: int, index: int) -> list[RunEvent]:
        """Return the events that lead from a state to a later one; all if ``before`` is -1."""
        start = self._ends[before - self.first] if before >= self.first else 0
        return self._events[start : None if index == self.last else self._ends[index - self.first]]

    def joints(
        self, first: int, end: int
    ) -> tuple[np.ndarray, dict[str, tuple[np.ndarray, np.ndarray]]]:
        """Return times [s] and joints of the kept states from ``first`` to before ``end`` [rad]."""
        # (n,), (n, nq) each
        some, found = self._part(first, end), {}
        for name in self._steps[-1]:
            rows = _array([steps[name] for steps in self._steps[some]])
            nq = (rows.shape[1] - TOOL) // len(STEP_FIELDS)
            found[name] = rows[:, :nq], rows[:, 2 * nq : 3 * nq]
        return np.array(self.times[some]), found

    @property
    def cameras(self) -> Sequence[SceneCamera]:
        """The cameras of the cell in this state."""
        return self._now.cameras

    @property
    def centre(self) -> np.ndarray:
        """Centre of the cell [m]."""  # (3,)
        return self._now.centre

    @property
    def extent(self) -> float:
        """Size of the cell [m]."""
        return self._now.extent

    def entities(self) -> dict[str, str]:
        """Return the present entities, with digests of their shapes."""
        return self._now.entities

    def shapes(self, entity: str) -> Mapping[str, Sequence[VisualShape]]:
        """Return the visible shapes of a present entity, by frame."""
        return self._shapes[self._now.entities[entity]]

    def poses(self) -> np.ndarray:
        """Return the poses of all frames; those of absent bodies are NaN."""
        poses = np.full((len(self.frames), 7), np.nan)
        poses[self._now.places] = self._poses[self.index - self.first]
        return poses

    # A recording

    def copy(self) -> "History":
        """Return a copy, for another thread."""
        with self._lock:
            copied = copy.copy(self)
            for name, value in vars(self).items():
                if isinstance(value, list):
                    setattr(copied, name, value[:])
        return copied

    def alike(self, first: int) -> int:
        """Return the number of states from one on in which the same things are in the cell."""
        starts = (look.first for look in self._looks if look.first > first)
        return min((*starts, self.last + 1)) - first

    def rows(
        self, first: int, end: int
    ) -> tuple[np.ndarray, list[str], np.ndarray, dict[str, tuple[np.ndarray, list[bool]]]]:
        """Return `alike` states: times [s], frames, poses, and the last step of each robot.

        A step has the fields of ``STEP_FIELDS``, the tool's position [m], and whether grippers and
        what they hold touched only each other; state 0 has none.
        """  # (n,), n_frames names, (n, n_frames, 7), (n, 6 nq + 3) and n each
        some, steps = self._part(first, end), {}
        made = self._steps[self._part(max(first, 1), end)]
        for name in made[-1] if made else ():
            of_robot = [one[name] for one in made]
            steps[name] = _array(of_robot), [free for _, free in of_robot]
        frames = [self.frames[i] for i in self._look_of(first).places.tolist()]
        return np.array(self.times[some]), frames, np.stack(self._poses[some]).astype(float), steps

    # Internal

    @property
    def _now(self) -> _Look:
        return self._look_of(self.index)

    def _look_of(self, index: int) -> _Look:
        return self._looks[bisect_right(self._looks, index, key=lambda one: one.first) - 1]

    def _part(self, first: int, end: int) -> slice:
        return slice(max(first - self.first, 0), max(end - self.first, 0))

    def _forget(self, count: int) -> None:
        """Forget the oldest states."""
        past = self._events[: self._ends[count]]
        kept = _latest(past)
        self._events[: len(past)] = kept
        gone = len(past) - len(kept)
        self._ends = [end - gone for end in self._ends[count:]]
        self.size -= gone * ITEM_BYTES
        self.size -= sum(map(_bytes, self._poses[:count], self._steps[:count]))
        for states in (self.times, self._poses, self._steps):
            del states[:count]
        self.first += count
        self.index = max(self.index, self.first)
        later = [look for look in self._looks if look.first > self.first]
        self._looks = self._looks[-len(later) - 1 :]
        used = {digest for look in self._looks for digest in look.entities.values()}
        self._shapes = {digest: one for digest, one in self._shapes.items() if digest in used}


def _bytes(poses: np.ndarray, steps: Mapping[str, Step]) -> int:
    """Return the estimated memory of a state."""
    return ITEM_BYTES + poses.nbytes + sum(len(row) for row, _ in steps.values())


def _array(steps: Sequence[Step]) -> np.ndarray:
    """Return the rows of some steps as one array."""
    return np.frombuffer(b"".join([row for row, _ in steps])).reshape(len(steps), -1)


def _latest(events: Iterable[RunEvent]) -> list[RunEvent]:
    """Return the last event of each kind about the same subject, in their order."""
    kept: dict[tuple[Any, ...], RunEvent] = {}
    for event in events:
        get: Callable[[str], Any] = event.data.get
        key = event.kind, *map(get, SUBJECTS)
        kept.pop(key, None)
        kept[key] = event
    return list(kept.values())
