"""The page of a run: scene, tree and controls in the browser."""

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from bt_manip.bt import NodeStatus
from bt_manip.cell import CellScene
from bt_manip.runner import KINDS, EventStream, Run, RunObserver, Station

from .controls import PAUSE_POLL, Controls
from .error_plot import PLOT_SAMPLES
from .scene_page import MakePanel, ScenePage
from .server import PORT

PAST = 60.0
"""Simulated time for which past states are kept [s]."""


class _State(NamedTuple):
    """Poses of the bodies at a time."""

    time: float
    frames: Sequence[str]
    poses: np.ndarray


class Page(ScenePage, RunObserver):
    """Shows a run in the browser; a thread of its own serves it on loopback.

    The run only leaves messages for that thread and never waits for a browser, except while it is
    paused. Watching without intervention does not change the run.

    Args:
        panels: Factories of the panels by name; see the hook ``register_panels``.
        port: The first port to try; 0: chosen by the system.
        speed: Initial speed, simulated seconds per second of wall time; None: no limit.
    """

    kinds = tuple(kind for kind in KINDS if kind != "contact")  # not shown

    def __init__(
        self,
        panels: Mapping[str, MakePanel] | None = None,
        *,
        port: int = PORT,
        speed: float | None = 1.0,
    ) -> None:
        self._cell: Any = None
        self._source: CellScene | None = None  # None: the scene has changed
        self._samples: list[tuple[float, dict[str, tuple[np.ndarray, np.ndarray]]]] = []
        self._past: deque[_State] = deque()
        self._wanted: float | None = None  # past time to show [s]
        ScenePage.__init__(self, lambda gui: Controls(gui, speed), panels or {}, port)

    def wait_until_open(self, patience: float, stop: Callable[[], bool]) -> bool:
        """Wait until a browser shows the scene; return whether it does.

        Args:
            patience: Longest wait [s].
            stop: Ends the wait when it returns True.
        """
        end = time.monotonic() + patience
        while not self.server.get_clients() and time.monotonic() < end and not stop():
            time.sleep(PAUSE_POLL)
        return bool(self.server.get_clients())

    def show_time(self, time: float | None) -> None:
        """Show a time of the last minute in all browsers [s]; None: the present."""
        self._wanted = time

    @property
    def stopped(self) -> bool:
        """Whether the run was stopped from the page."""
        return self.controls.stopped

    def run_started(self, run: Run) -> None:
        """Show the name of the tree, and start the panels."""
        self._run, self._cell = run, run.station.cell
        self._samples.clear()
        self._forget_past()
        self._show_tree(run.request.tree.name)
        for panel in self._panels:
            panel.start(run)

    def after_compile(self) -> None:
        """Let the next update show added and removed entities."""
        self._source = None

    def cycle_started(self, cycle: int) -> None:
        """Let the next update show the randomized values."""
        self._source = None

    def before_tick(self) -> None:
        """Wait while the run is paused."""
        if self.controls.paused:
            self.refresh(now=True)
            self.controls.wait(self.refresh)

    def after_tick(self) -> None:
        """Update the page if it is open and an update is due."""
        robots = self._run.station.robots.values()
        joints = {one.name: (one.robot.q, one.arm.q_ref) for one in robots}
        self._samples.append((self._cell.time, joints))
        if len(self._samples) >= PLOT_SAMPLES:
            self._hand_over_samples()
        for panel in self._panels:
            panel.end_tick()
        if self.is_open:
            self.refresh()

    def run_ended(self) -> None:
        """Show the last state."""
        self.controls.end()
        self.refresh(now=True)

    def show_prepared(self, run: Run) -> None:
        """Show the tree of a run that has not begun, so that breakpoints can be set."""
        self._show_tree(run.request.tree.name)
        self.controls.show_ready()
        events = EventStream(run)
        events.listen(self.handle, ("tree",))
        events.begin_cycle(0)
        self.refresh(now=True)

    def begin_idle(self, station: Station) -> None:
        """Show a cell in which no tree runs; a new cell clears the panels."""
        if station.cell is not self._cell:
            self._forget_past()
            for panel in self._panels:
                panel.reset()
        self._cell, self._source = station.cell, None
        for panel in self._panels:
            panel.begin_idle(station)
        self.refresh(now=True)

    def tick(self) -> NodeStatus:
        """Let panels act at a tick between runs, e.g. for jogging, and update the page."""
        for panel in self._panels:
            panel.idle_tick()
        self.refresh()
        return NodeStatus.RUNNING

    # Internal

    def _catch_up(self) -> None:
        cell = self._cell
        if self._source is None:
            self._source = CellScene(cell.model, cell.data, cell.entities)
            self._scene.bind(self._source)
        if self._samples:
            self._hand_over_samples()

    def _show_scene(self) -> None:
        """Store the present poses; show them, or those of the selected past time."""
        source, past, wanted = self._scene.source, self._past, self._wanted
        if not past or self._cell.time > past[-1].time:
            past.append(_State(self._cell.time, source.frames, source.poses()))
            while past[0].time < self._cell.time - PAST:
                past.popleft()
        self.shown_time = None
        poses = source.poses()
        if wanted is not None:
            state = next((one for one in reversed(past) if one.time <= wanted), past[0])
            self.shown_time = state.time
            index = {name: i for i, name in enumerate(state.frames)}
            for i, name in enumerate(source.frames):  # later entities keep their present pose
                if name in index:
                    poses[i] = state.poses[index[name]]
        self._scene.show(poses)

    def _forget_past(self) -> None:
        self._past.clear()
        self._wanted = None

    def _hand_over_samples(self) -> None:
        samples, self._samples = self._samples, []
        times = np.array([time for time, _ in samples])
        joints = {}
        for name in samples[0][1]:
            q, q_ref = zip(*(sample[name] for _, sample in samples), strict=True)
            joints[name] = np.array(q), np.array(q_ref)
        for panel in self._panels:
            panel.sample(times, joints)
