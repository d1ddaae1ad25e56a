"""The page of a recording."""

import time
from collections.abc import Callable, Mapping, Sequence

from bt_manip.exceptions import BtManipError
from bt_manip_recording import RecordedScene, Recording, Timeline

from .breakpoints import problem_of
from .controls import SPEEDS, Controls
from .gui import Gui
from .quantities import RecordedQuantities
from .scene_page import POSE_PERIOD, MakePanel, ScenePage
from .server import PORT

LONGEST_ADVANCE = 0.5
"""Longest wall time that one step of playing covers [s]."""


class ReplayControls(Controls):
    """Plays a recording: play and pause, single ticks, speed; a note is beside the state."""

    texts = ("playing", "Play")
    speeds = SPEEDS

    def __init__(self, gui: Gui, speed: float, scene: RecordedScene, note: str) -> None:
        super().__init__(gui, speed)
        self.paused, self._cell, self._note = True, scene, note
        self._stop.visible = False

    def leave_breakpoint(self, paused: bool) -> None:
        """Undo the effect of breakpoints passed by a seek: pause or play as before."""
        self.paused, self._broken = paused, ""


class ReplayPage(ScenePage):
    """Shows a recording in the browser at any of its times, like the page of the run.

    Panels get the events of the recording; panels that need a run are left out.

    Args:
        recording: The recording.
        panels: Factories of the panels by name; see the hook ``register_panels``.
        port: The first port to try; 0: chosen by the system.
        start: Initial simulated time [s]; None: the start of the run.
        speed: Initial speed, simulated seconds per second of wall time.
        breakpoints: Names or paths of the nodes at whose start it pauses.

    Attributes:
        quantities: The recorded quantities over time.

    Raises:
        BtManipError: If the recording has no complete chunk, or its tree no node of a breakpoint.
    """

    controls: ReplayControls

    def __init__(
        self,
        recording: Recording,
        panels: Mapping[str, MakePanel] | None = None,
        *,
        port: int = PORT,
        start: float | None = None,
        speed: float = 1.0,
        breakpoints: Sequence[str] = (),
    ) -> None:
        self.past = Timeline(recording)
        scene = self.past.scene
        events = self.past.events(-1, len(scene.times) - 1)
        nodes = [node for one in events if one.kind == "tree" for node in one.data["nodes"]]
        if problem := problem_of(breakpoints, nodes):
            raise BtManipError(problem)
        self.quantities = RecordedQuantities(recording, self.past)
        shown = {n: make for n, make in (panels or {}).items() if not getattr(make, "needs_run", 0)}
        cut = f"The recording is incomplete: it was cut off after {scene.times[-1]:.2f} s."
        note = "" if recording.complete else cut
        super().__init__(lambda gui: ReplayControls(gui, speed, scene, note), shown, port)
        self.controls.breakpoints = frozenset(breakpoints)
        self._show_tree(recording.identity["tree"])
        for event in events:
            for panel in self._present:
                panel.handle(event)
        self.seek(float(scene.times[0]) if start is None else start)

    def seek(self, time: float) -> None:
        """Show the state after the last tick that ended at or before a time [s]."""
        scene, paused = self.past.scene, self.controls.paused
        scene.seek(time)
        self._go_to(scene.index)
        self.controls.leave_breakpoint(paused)
        self.refresh(now=True)

    def serve(self, stop: Callable[[], bool]) -> None:
        """Play under the controls until ``stop`` returns True."""
        before = time.perf_counter()
        position = self.past.scene.time
        while not stop():
            now = time.perf_counter()
            position = self._act(position, min(now - before, LONGEST_ADVANCE))
            before = now
            self.refresh()
            time.sleep(POSE_PERIOD)

    # Internal

    def _act(self, position: float, elapsed: float) -> float:
        """Execute commands of the controls, or play for some wall time; return the time reached."""
        controls, times = self.controls, self.past.scene.times
        last = len(times) - 1
        wanted, self._wanted = self._wanted, None
        if wanted is not None:
            self.seek(wanted)
        elif controls.take_step():
            self._go_to(min(self._index + 1, last))
        elif not controls.paused:
            if self._index == last:  # play again
                self.seek(times[0])
                position = times[0]
            assert controls.speed is not None
            position += elapsed * controls.speed
            while not controls.paused and self._index < last and times[self._index + 1] <= position:
                self._go_to(self._index + 1)
            controls.paused |= self._index == last
            if not controls.paused:
                return position
        return float(times[self._index])
