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
"""Simulated time that can be looked back at [s]."""


class _State(NamedTuple):
    """The poses of the bodies at a time."""

    time: float
    frames: Sequence[str]
    poses: np.ndarray


class Page(ScenePage, RunObserver):
    """Shows a run in the browser; viser serves it on loopback in a thread of its own.

    The run only leaves messages for that thread and never waits for a page, except when it is
    paused there. A run that is watched without intervention is the same run as without a page.
    """

    kinds = tuple(kind for kind in KINDS if kind != "contact")  # not shown

    def __init__(
        self,
        panels: Mapping[str, MakePanel] | None = None,
        *,
        port: int = PORT,
        speed: float | None = 1.0,
    ) -> None:
        """Start the server.

        Args:
            panels: Makers of the panels by name, as hooks ``register_panels`` register them.
            port: The first port that is tried; 0 lets the system choose.
            speed: Simulated seconds per second of wall time at first; None is without limit.
        """
        self._cell: Any = None
        self._source: CellScene | None = None  # None: the scene has changed
        self._samples: list[tuple[float, dict[str, tuple[np.ndarray, np.ndarray]]]] = []
        self._past: deque[_State] = deque()
        self._wanted: float | None = None  # time to look back at [s]
        ScenePage.__init__(self, lambda gui: Controls(gui, speed), panels or {}, port)

    def wait_until_open(self, patience: float, stop: Callable[[], bool]) -> bool:
        """Wait until a browser shows the scene; return whether one does.

        Args:
            patience: Longest wait [s].
            stop: Ends the wait where it returns True.
        """
        end = time.monotonic() + patience
        while not self.server.get_clients() and time.monotonic() < end and not stop():
            time.sleep(PAUSE_POLL)
        return bool(self.server.get_clients())

    def show_time(self, time: float | None) -> None:
        """Let all browsers look back at another time of the last minute; None is the present."""
        self._wanted = time

    @property
    def stopped(self) -> bool:
        """Whether the run was stopped from the page."""
        return self.controls.stopped

    def run_started(self, run: Run) -> None:
        """Show the name of the tree."""
        self._run, self._cell = run, run.station.cell
        self._samples.clear()
        self._forget_past()
        self._show_tree(run.request.tree.name)
        for panel in self._panels:
            panel.start(run)

    def after_compile(self) -> None:
        """Let the next update add and remove the nodes of entities that came and went."""
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
        """Update the page if it is open and the last update is old enough."""
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
        """Show the tree of a run that has not begun, ready for breakpoints."""
        self._show_tree(run.request.tree.name)
        self.controls.show_ready()
        events = EventStream(run)
        events.listen(self.handle, ("tree",))
        events.begin_cycle(0)
        self.refresh(now=True)

    def begin_idle(self, station: Station) -> None:
        """Show a cell in which no tree runs; in a new cell nothing has happened yet."""
        if station.cell is not self._cell:
            self._forget_past()
            for panel in self._panels:
                panel.reset()
        self._cell, self._source = station.cell, None
        for panel in self._panels:
            panel.begin_idle(station)
        self.refresh(now=True)

    def tick(self) -> NodeStatus:
        """Let panels act at a tick between runs, such as for jogging, and update the page."""
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
        """Show the poses of the present, or of the time to look back at, and keep the former."""
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
            for i, name in enumerate(source.frames):  # what was not there then stays where it is
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
