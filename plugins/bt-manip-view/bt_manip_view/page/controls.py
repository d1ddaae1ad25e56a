"""Controls of a run: pause, step, speed, stop."""

import math
import threading
from collections.abc import Callable, Collection, Mapping
from typing import Any

from bt_manip.exceptions import BtManipError
from bt_manip.runner import Pacing, Run, RunEvent, Station

from .breakpoints import Breakpoints
from .gui import Gui
from .panel import Panel

SPEEDS = {"1/10": 0.1, "1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "5": 5.0}
"""Options of the speed: simulated seconds per second of wall time."""

PAUSE_POLL = 0.05
"""Wall time between two checks of a paused run [s]."""


class Controls(Panel):
    """Pauses, steps, slows down and stops a run.

    Callbacks of the inputs only set attributes that the thread of the run reads between ticks.

    Attributes:
        paused: Whether the run waits before its next tick.
        stopped: Whether the run shall end.
        speed: Simulated seconds per second of wall time; None: no limit.
        task: Name of the tree.
        marked: Paths of the nodes at which the tree's document sets breakpoints.
        edited: Whether the file of the tree was edited since the run pauses.
        start_time: Simulated time of the cell at which the clock of the run begins [s].
        end_time: Time of that clock at which the run ended [s]; None while it goes on.

    Raises:
        BtManipError: If the speed is not a positive number.
    """

    texts = ("running", "Continue")
    """State shown while time advances, and label of the button when paused."""
    speeds: Mapping[str, float | None] = {**SPEEDS, "as fast as possible": None}
    """Offered speeds."""

    def __init__(self, gui: Gui, speed: float | None) -> None:
        if speed is not None and not 0.0 < speed < math.inf:
            raise BtManipError(f"the speed must be a positive number, got {speed:g}")
        self.paused = self.stopped = self.edited = False
        self.task = ""
        self.marked: Collection[str] = ()
        self._breakpoints = Breakpoints()
        self._broken = ""  # path of the node whose breakpoint paused the run
        self._steps = 0
        self._changed = threading.Event()
        self._state = self._cycle = self._note = ""
        self._run: Any = None
        self._cell: Any = None  # has the time
        self.start_time = 0.0
        self.end_time: float | None = None
        self._speeds = dict(self.speeds)
        if speed not in self._speeds.values():
            self._speeds[f"{speed:g}"] = speed
        self.speed = speed
        self._pacing = Pacing(speed)
        self._status = gui.add("status", task="", look="", text="", note="")
        self._pause = gui.add_button("Pause", style="primary", hint="Pause or go on (space)")
        self._pause.on_click(self._toggle)
        self._step = gui.add_button("Step", hint="Pause, or make one tick")
        self._step.on_click(self._add_step)
        self._stop = gui.add_button("Stop", style="danger", hint="Stop the arms and end the run")
        self._stop.on_click(self._end)
        chosen = next(name for name, value in self._speeds.items() if value == speed)
        self._choice = gui.add_dropdown(
            "Speed", list(self._speeds), initial_value=chosen,
            hint="Simulated seconds per second of wall time",
        )  # fmt: skip
        self._choice.on_update(self._set_speed)
        self._in_run = (self._pause, self._step, self._stop)

    @property
    def breakpoints(self) -> frozenset[str]:
        """Paths of the nodes of this tree at whose start the run pauses."""
        return self._breakpoints.paths

    @breakpoints.setter
    def breakpoints(self, paths: Collection[str]) -> None:
        self._breakpoints.choose(paths)

    @property
    def time(self) -> float:
        """The simulated time of the run; it stops at the end of the run [s]."""
        if self.end_time is not None:
            return self.end_time
        return 0.0 if self._cell is None else float(self._cell.time) - self.start_time

    def start(self, run: Run) -> None:
        """Enable the controls, and end the run when Stop is pressed."""
        self._run, self._cell, self.end_time = run, run.station.cell, None
        request = run.request
        names = list(run.station.robots)
        robots = " and ".join(names) if len(names) > 1 else request.robot
        self._note = f"{robots} in {request.scene}, seed {request.seed}"
        for control in self._in_run:
            control.disabled, control.visible = False, True
        stop = run.stop
        run.stop = lambda: self.stopped or stop()
        self._pacing.start(run.station.cell.time)

    def wait(self, refresh: Callable[[], None]) -> None:
        """Wait while the run is paused; call `refresh` regularly meanwhile."""
        while self.paused and not self._run.stop():
            if self.take_step():
                break
            refresh()
            self._changed.wait(PAUSE_POLL)
            self._changed.clear()
            self._pacing.start(self._run.station.cell.time)

    def take_step(self) -> bool:
        """Return whether a single tick was requested; consume one request."""
        self._steps, wanted = max(self._steps - 1, 0), self._steps > 0
        return wanted

    def reset(self) -> None:
        """Clear the cycle."""
        self._state = self._cycle = ""

    def handle(self, event: RunEvent) -> None:
        """Pause at a breakpoint; store the cycle."""
        data = event.data
        if event.kind == "tree":
            self._breakpoints.show(self.task, data["nodes"], self.marked)
        elif event.kind == "cycle":
            self._cycle = f"cycle {data['cycle'] + 1}"
            self._state = "" if data["status"] == "RUNNING" else data["status"]
        elif event.kind == "status" and data["path"] in self.breakpoints:
            if data["old"] != "RUNNING" and data["status"] not in ("IDLE", "SKIPPED"):
                self.paused, self._broken = True, data["path"]

    def end_tick(self) -> None:
        """Wait as the selected speed requires."""
        if self.speed is not self._pacing.factor:
            self._pacing = Pacing(self.speed)
            self._pacing.start(self._run.station.cell.time)
        self._pacing.wait(self._run.station.cell.time)

    def end(self) -> None:
        """Show that the run has ended."""
        self._state = f"{'stopped' if self.stopped else 'ended'} {self._state}".rstrip()
        self.paused, self._steps = False, 0
        self.end_time = self.time
        for control in self._in_run:
            control.disabled = True

    def begin_idle(self, station: Station) -> None:
        """Hide the controls of a run; in a new cell no time has passed."""
        if station.cell is not self._cell:
            self._cell, self._note = station.cell, ""
            self.show_ready()
        for control in self._in_run:
            control.visible = False

    def show_ready(self) -> None:
        """Show that the tree is ready to run."""
        self._state, self._cycle, self.end_time = "ready", "", 0.0

    def draw(self) -> None:
        """Send the state of the run if it has changed."""
        if self._cell is None:
            return
        running, go_on = self.texts
        state = self._state or ("paused" if self.paused else running)
        look = state.split()[-1]
        if self._broken and self.paused:
            state, look = f"{state} at {self._broken}", "paused"
        cycle = f"{self._cycle}, " if self._cycle else ""
        self._status.text = f"{cycle}{self.time:.2f} s: {state}"
        self._status.look, self._status.task, self._status.note = look, self.task, self._note
        self._pause.label = go_on if self.paused else "Pause"

    # Callbacks

    def _toggle(self, _: Any) -> None:
        self._steps, self._broken = 0, ""
        self.paused = not self.paused
        self._changed.set()

    def _add_step(self, _: Any) -> None:
        self._steps += self.paused
        self._broken, self.paused = "", True
        self._changed.set()

    def _set_speed(self, _: Any) -> None:
        self.speed = self._speeds[self._choice.value]

    def _end(self, _: Any) -> None:
        self.stopped = True
        self._changed.set()
