"""The page of a recording."""

import time
from collections.abc import Callable, Mapping

from bt_manip_recording import RecordedScene, Recording, Timeline

from .controls import UNLIMITED, Controls
from .error_plot import PLOT_SAMPLES
from .gui import Gui
from .scene_page import POSE_PERIOD, MakePanel, ScenePage
from .server import PORT

LONGEST_ADVANCE = 0.5
"""Longest wall time that one step of playing covers [s]."""


class ReplayControls(Controls):
    """Plays a recording: play and pause, single ticks, speed.

    Args:
        gui: The inputs of the page.
        speed: Initial speed, simulated seconds per second of wall time.
        scene: The recorded scene, whose time is shown.
        note: A note beside the state.
    """

    texts = ("playing", "Play")

    def __init__(self, gui: Gui, speed: float, scene: RecordedScene, note: str) -> None:
        super().__init__(gui, speed)
        self.paused, self._cell, self._note = True, scene, note
        self._wanted: float | None = None
        self._stop.visible = False

    @property
    def speed(self) -> float:
        """Simulated seconds per second of wall time."""
        assert self._speed is not None
        return self._speed

    def want(self, time: float) -> None:
        """Request another time [s]."""
        self._wanted = time
        self._changed.set()

    def leave_breakpoint(self, paused: bool) -> None:
        """Undo the effect of breakpoints passed by a seek: pause or play as before."""
        self.paused, self._broken = paused, ""

    def take_time(self) -> float | None:
        """Return the requested time and clear the request; None without one [s]."""
        wanted, self._wanted = self._wanted, None
        return wanted

    def _offered(self) -> tuple[str, ...]:
        return tuple(name for name in self._speeds if name != UNLIMITED)


class ReplayPage(ScenePage):
    """Shows a recording in the browser at any of its times, like the page of the run.

    Panels get the events of the recording; panels that need a run are left out.

    Args:
        recording: The recording.
        panels: Factories of the panels by name; see the hook ``register_panels``.
        port: The first port to try; 0: chosen by the system.
        start: Initial simulated time [s]; None: the start of the run.
        speed: Initial speed, simulated seconds per second of wall time.

    Raises:
        BtManipError: If the recording has no complete chunk.
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
    ) -> None:
        self._timeline, self._index = Timeline(recording), -1
        self._entities: dict[str, int] = {}
        scene = self._timeline.scene
        shown = {n: make for n, make in (panels or {}).items() if not getattr(make, "needs_run", 0)}
        cut = f"The recording is incomplete: it was cut off after {scene.times[-1]:.2f} s."
        note = "" if recording.complete else cut
        super().__init__(lambda gui: ReplayControls(gui, speed, scene, note), shown, port)
        self._show_tree(recording.identity["tree"])
        first, end = float(scene.times[0]), float(scene.times[-1])
        for panel in self._panels:
            events = self._timeline.events(-1, len(scene.times) - 1)
            panel.show_recording(events, first, end)
        self.seek(first if start is None else start)

    def show_time(self, time: float | None) -> None:
        """Request the state at another time [s]."""
        if time is not None:
            self.controls.want(time)

    def seek(self, time: float) -> None:
        """Show the state after the last tick that ended at or before a time [s]."""
        scene, paused = self._timeline.scene, self.controls.paused
        scene.seek(time)
        self._go_to(scene.index)
        self.controls.leave_breakpoint(paused)
        self.refresh(now=True)

    def serve(self, stop: Callable[[], bool]) -> None:
        """Play under the controls until ``stop`` returns True."""
        before = time.perf_counter()
        position = self._timeline.scene.time
        while not stop():
            now = time.perf_counter()
            position = self._act(position, min(now - before, LONGEST_ADVANCE))
            before = now
            self.refresh()
            time.sleep(POSE_PERIOD)

    # Internal

    def _act(self, position: float, elapsed: float) -> float:
        """Execute commands of the controls, or play; return the simulated time reached.

        Args:
            position: The simulated time reached so far [s].
            elapsed: Wall time since then [s].
        """
        controls, times = self.controls, self._timeline.scene.times
        last = len(times) - 1
        if (wanted := controls.take_time()) is not None:
            self.seek(wanted)
        elif controls.take_step():
            self._go_to(min(self._index + 1, last))
        elif not controls.paused:
            if self._index == last:  # play again
                self.seek(times[0])
                position = times[0]
            position += elapsed * controls.speed
            while not controls.paused and self._index < last and times[self._index + 1] <= position:
                self._go_to(self._index + 1)
            controls.paused |= self._index == last
            if not controls.paused:
                return position
        return float(times[self._index])

    def _go_to(self, index: int) -> None:
        """Bring scene and panels to another state."""
        timeline, before = self._timeline, self._index
        if index < before:
            before = -1
            for panel in self._panels:
                panel.reset()
        for event in timeline.events(before, index):
            self.handle(event)
        first = max(before + 1, index + 1 - PLOT_SAMPLES, 1)  # state 0 has no joint samples
        if first <= index:
            times, joints = timeline.joints(first, index + 1)
            for panel in self._panels:
                panel.sample(times, joints)
        self._index = timeline.scene.index = index
        if self._entities != (present := timeline.scene.entities()):
            self._entities = present
            self._scene.bind(timeline.scene)
