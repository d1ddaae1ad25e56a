"""The page of a run: scene, tree and controls in the browser."""

import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from bt_manip.bt import NodeStatus
from bt_manip.cli import findings_of
from bt_manip.runner import KINDS, EventStream, PendingSteps, Run, RunEvent, RunObserver, Station
from bt_manip_recording import CellScene

from .breakpoints import marked_paths
from .controls import PAUSE_POLL, Controls
from .findings import count_lines, findings_at_nodes
from .history import History, Step
from .panel import Panel
from .scene_page import MakePanel, ScenePage
from .server import PORT


class Page(ScenePage, RunObserver):
    """Shows a run in the browser; a thread of its own serves it on loopback.

    The run only leaves messages for that thread and never waits for a browser, except while it is
    paused. Watching without intervention does not change the run.

    Args:
        panels: Factories of the panels by name; see the hook ``register_panels``.
        port: The first port to try; 0: chosen by the system.
        speed: Initial speed, simulated seconds per second of wall time; None: no limit.

    Attributes:
        watches: Whether an edited file of the tree is read during the run.
    """

    watches = False
    kinds = tuple(kind for kind in KINDS if kind != "contact")  # not shown

    def __init__(
        self,
        panels: Mapping[str, MakePanel] | None = None,
        *,
        port: int = PORT,
        speed: float | None = 1.0,
    ) -> None:
        self._cell: Any = None
        self.past = History()
        self._source: CellScene | None = None  # None: the scene has changed
        self._bound: CellScene | None = None  # what the scene shows; None: the past
        self._steps: dict[str, Step] = {}  # the last control step of each robot
        self._lines: dict[str, int] = {}  # number in each file of the tree when it was read
        ScenePage.__init__(self, lambda gui: Controls(gui, speed), panels or {}, port)
        self._present.append(self.controls)

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

    @property
    def span(self) -> tuple[float, float | None]:
        """Start of the kept past, and end of a run that has ended [s]."""
        start = self.past.times[0] if self.past.times else 0.0
        return start, self.controls.end_time

    def handle(self, event: RunEvent) -> None:
        """Pass an event to the panels that show the present, and keep it for the others.

        An event with a new tree also sets the breakpoints in its file, and the findings at nodes.
        """
        if event.kind == "tree":
            self.controls.marked = marked_paths(self._tree)
            self._lines = count_lines(self._tree)
            self.findings = findings_at_nodes(self._tree, self._tree.warnings)
        elif event.kind == "edit" and self._lines == count_lines(self._tree):
            errors = findings_of(event.data["problems"])
            self.findings = findings_at_nodes(self._tree, (*self._tree.warnings, *errors))
        if self.controls.start_time:
            event = event._replace(time=event.time - self.controls.start_time)
        if event.kind != "tick":
            self.past.add(event)
        for panel in self._of_present():
            panel.handle(event)

    @property
    def stopped(self) -> bool:
        """Whether the run was stopped from the page."""
        return self.controls.stopped

    def run_started(self, run: Run) -> None:
        """Show the name of the tree, and start the panels."""
        cell = run.station.cell
        # A run that goes on in a cell which rested here begins at 0.
        self.controls.start_time = cell.time if cell is self._cell else 0.0
        self._run, self._tree, self._cell = run, run.tree, cell
        self._forget_past()
        self._show_tree(run.request.tree.name)
        self._logs = run.log.steps()
        for name, log in self._logs.items():
            log.readers.append(partial(self._keep_step, name))
        for panel in self._panels:
            panel.start(run)

    def after_compile(self) -> None:
        """Let the next update show added and removed entities."""
        self._source = None

    def cycle_started(self, cycle: int) -> None:
        """Let the next update show the randomized values; keep the state before the first tick."""
        self._source = None
        if not self.past.times:
            self._keep_state()

    def before_tick(self) -> None:
        """Wait while the run is paused."""
        self.past.begin_tick()
        if self.controls.paused:
            self.refresh(now=True)
            stamps = self._stamps()
            self.controls.wait(lambda: self._refresh_paused(stamps))
            self.controls.edited = False

    def after_tick(self) -> None:
        """Update the page if it is open and an update is due."""
        self._keep_state()
        self._sample(self.past.last, self.past.last + 1, self._of_present())
        for panel in self._panels:
            panel.end_tick()
        if self.is_open:
            self.refresh()

    def run_ended(self) -> None:
        """Show the last state."""
        self.controls.end()
        self.refresh(now=True)

    def show_prepared(self, run: Run, errors: Iterable[Any] = ()) -> None:
        """Show the tree of a run that has not begun, so that breakpoints can be set.

        Args:
            run: The run.
            errors: Errors of its tree in this cell.
        """
        self._tree = run.tree
        self._forget_past()
        self._show_tree(run.request.tree.name)
        self.controls.show_ready()
        events = EventStream(run)
        events.listen(self.handle, ("tree",))
        events.begin_cycle(0)
        self.findings = findings_at_nodes(run.tree, (*run.tree.warnings, *errors))
        self.refresh(now=True)

    def show_errors(self, name: str, errors: Iterable[Any]) -> None:
        """Show the errors of a tree that cannot be built, in place of its nodes.

        Args:
            name: Its name.
            errors: The errors.
        """
        self._forget_past()
        self._show_tree(name)
        self.findings = {}
        for kind, data in (
            ("tree", {"nodes": [], "results": []}), ("edit", {"problems": [*map(str, errors)]})
        ):  # fmt: skip
            for panel in self._panels:
                panel.handle(RunEvent(0.0, kind, data))
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

    def _refresh_paused(self, stamps: list[int]) -> None:
        """Update the page of a paused run; say whether its file was edited meanwhile."""
        self.controls.edited = self._stamps() != stamps
        self.refresh()

    def _stamps(self) -> list[int]:
        """Return when the files of a tree were edited that is reloaded then [ns]."""
        document = self._tree.document if self.watches else None
        files = [] if document is None else document.files
        return [file.stat().st_mtime_ns for file in files if file.exists()]

    def _catch_up(self) -> None:
        """Show the selected past time, else the present."""
        past, wanted = self.past, self._wanted
        if wanted is not None and past.times:
            if self.shown_time is None:
                self._index, self._entities, self._bound = past.last, {}, None
            if self._index < past.first:  # it was forgotten meanwhile
                self._index = past.last + 1
            past.seek(wanted)
            self._go_to(past.index)
            self.shown_time = past.time
            return
        if self.shown_time is not None:
            self._go_to(past.last)
            self.shown_time = None
        if self._bound is not (source := self._present_scene()):
            self._bound = source
            self.view.bind(source)

    def _present_scene(self) -> CellScene:
        """Return the scene of the cell, which the past has, too."""
        if self._source is None:
            self._source = CellScene(self._cell.model, self._cell.data, self._cell.entities)
            self.past.look(self._source)
        return self._source

    def _keep_state(self) -> None:
        """Add the present state to the past."""
        self._present_scene()
        for name, log in self._logs.items():
            self._keep_step(name, log.pending)
        data, time = self._cell.data, self._cell.time - self.controls.start_time
        poses = np.concatenate((data.xpos, data.xquat), axis=1, dtype=np.float32)
        self.past.end_tick(time, poses, dict(self._steps))

    def _keep_step(self, robot: str, steps: PendingSteps) -> None:
        """Keep the last step; it may be the last of a block."""
        if steps.touches:
            self._steps[robot] = steps.rows[-1], steps.touches[-1].free

    def _of_present(self) -> list[Panel]:
        """Return the panels that show the present now."""
        return self._panels if self.shown_time is None else self._present

    def _forget_past(self) -> None:
        self.past = History()
        self._source = self._bound = self._wanted = self.shown_time = None
        self._steps = {}
