"""The controls of a run: pause, step, speed, stop."""

import math
import threading
from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

from bt_manip.exceptions import BtManipError
from bt_manip.runner import Pacing, RunEvent

from .panel import Panel, block

if TYPE_CHECKING:
    from bt_manip.runner import Run, Station


SPEEDS = {"1/10": 0.1, "1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "5": 5.0}
"""Choices of the speed: simulated seconds per second of wall time."""

UNLIMITED = "as fast as possible"
"""Choice of no limit of the speed."""

PAUSE_POLL = 0.05
"""Wall time between two checks of a paused run [s]."""


class Controls(Panel):
    """Pauses, steps, slows down and stops a run.

    viser calls the callbacks of the inputs in threads of its own: they only set what the thread
    of the run reads between two ticks.

    Attributes:
        paused: Whether the run waits before its next tick.
        stopped: Whether the run has to end.
        breakpoints: Paths of the nodes at whose start the run pauses.
    """

    texts = ("running", "Continue")
    """The state that is shown while time goes on, and the label of the button when it is paused."""

    def __init__(self, gui: Any, speed: float | None) -> None:
        """Add the inputs to the current container.

        Args:
            gui: viser's ``GuiApi``.
            speed: Simulated seconds per second of wall time at first; None is without limit.

        Raises:
            BtManipError: If the speed is not a positive number.
        """
        if speed is not None and not 0.0 < speed < math.inf:
            raise BtManipError(f"the speed must be a positive number, got {speed:g}")
        self.paused = self.stopped = False
        self.breakpoints: frozenset[str] = frozenset()
        self._broken = ""  # path of the node at which the run has paused
        self._steps = 0
        self._changed = threading.Event()
        self._state = self._cycle = ""
        self._run: Any = None
        self._cell: Any = None  # has the time
        speeds = dict(SPEEDS)
        if speed is not None and speed not in speeds.values():
            speeds[f"{speed:g}"] = speed
        self._speeds: dict[str, float | None] = {**speeds, UNLIMITED: None}
        self._speed = speed
        self._pacing = Pacing(speed)
        self._html = gui.add_html("")
        self._pause = gui.add_button("Pause")
        self._pause.on_click(self._toggle)
        self._step = gui.add_button("Step one tick")
        self._step.on_click(self._add_step)
        chosen = next(name for name, value in self._speeds.items() if value == speed)
        self._choice = gui.add_dropdown(
            "Speed", tuple(self._speeds), initial_value=chosen,
            hint="Simulated seconds per second of wall time",
        )  # fmt: skip
        self._choice.on_update(self._set_speed)
        self._stop = gui.add_button("Stop", color="red", hint="Stop the arms and end the run")
        self._stop.on_click(self._end)
        self._in_run = (self._pause, self._step, self._stop)

    def start(self, run: "Run") -> None:
        """Let the run end when it is stopped here."""
        self._run, self._cell = run, run.station.cell
        for control in self._in_run:
            control.disabled, control.visible = False, True
        stop = run.stop
        run.stop = lambda: self.stopped or stop()
        self._pacing.start(run.station.cell.time)

    def wait(self, refresh: Callable[[], None]) -> None:
        """Return when the next tick is due: simulated time stands still meanwhile.

        Args:
            refresh: Called regularly while the run is paused.
        """
        waited = False
        while self.paused and not self._run.stop():
            if self.take_step():
                break
            waited = True
            refresh()
            self._changed.wait(PAUSE_POLL)
            self._changed.clear()
        if waited:
            self._pacing.start(self._run.station.cell.time)

    def take_step(self) -> bool:
        """Return whether a single tick was asked for, once for each."""
        self._steps, wanted = max(self._steps - 1, 0), self._steps > 0
        return wanted

    def reset(self) -> None:
        """Forget the cycle."""
        self._state = self._cycle = ""

    def handle(self, event: RunEvent) -> None:
        """Pause at a breakpoint; keep the cycle."""
        data = event.data
        if event.kind == "cycle":
            self._cycle = f"cycle {data['cycle'] + 1}"
            self._state = "" if data["status"] == "RUNNING" else data["status"]
        elif event.kind == "status" and data["path"] in self.breakpoints:
            if data["old"] != "RUNNING" and data["status"] not in ("IDLE", "SKIPPED"):
                self.paused, self._broken = True, data["path"]

    def end_tick(self) -> None:
        """Keep the chosen speed."""
        speed = self._speed
        if speed is not self._pacing.factor:
            self._pacing = Pacing(speed)
            self._pacing.start(self._run.station.cell.time)
        self._pacing.wait(self._run.station.cell.time)

    def end(self) -> None:
        """Show that the run has ended."""
        self._state = f"{'stopped' if self.stopped else 'ended'} {self._state}".rstrip()
        self.paused, self._steps = False, 0
        for control in self._in_run:
            control.disabled = True

    def begin_idle(self, station: "Station") -> None:
        """Show the time of the cell, and no controls that are for a run."""
        if station.cell is not self._cell:
            self._cell, self._cycle, self._state = station.cell, "", "ready"
        for control in self._in_run:
            control.visible = False

    def draw(self) -> None:
        """Send the state of the run if it has changed."""
        if self._cell is None:
            return
        running, go_on = self.texts
        state = self._state or ("paused" if self.paused else running)
        if self._broken and self.paused:
            state += f" at {self._broken}"
        cycle = f"{escape(self._cycle)}, " if self._cycle else ""
        text = f"{cycle}{self._cell.time:.2f} s: {escape(state)}"
        self._html.content = block(text, "font-weight:bold;font-size:1em")
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
        self._speed = self._speeds[self._choice.value]

    def _end(self, _: Any) -> None:
        self.stopped = True
        self._changed.set()
