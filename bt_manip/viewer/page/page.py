"""The page of a run: scene, tree and controls in the browser."""

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from bt_manip.cell import CellScene
from bt_manip.runner import EventStream, RunEvent

from .controls import Controls
from .panel import Panel
from .scene import SceneView
from .server import HOST, PORT, close_server, open_server

POSE_PERIOD = 1.0 / 20.0
"""Wall time between two updates of the poses [s]."""

PANEL_PERIOD = 1.0 / 10.0
"""Wall time between two updates of the panels [s]."""

BRIGHTNESS = 0.4
"""Intensity of the environment's light: with viser's 1, light colours of cells look white."""

WIDTH = 420
"""Width of the panels [pixels]."""


class Page(EventStream):
    """Shows a run in the browser; viser serves it on loopback in a thread of its own.

    The run only leaves messages for that thread and never waits for a page, except when it is
    paused there. A run that is watched without intervention is the same run as without a page.

    Attributes:
        url: Address of the page.
        server: The ``viser.ViserServer``.
        controls: Pauses and stops the run.
    """

    def __init__(
        self,
        panels: Mapping[str, Callable[["Page"], Panel]] | None = None,
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
        super().__init__(self._handle)
        server = self.server = open_server(port)
        self.url = f"http://{HOST}:{server.get_port()}"
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.set_panel_label("bt-manip")
        server.scene.configure_environment_map(environment_intensity=BRIGHTNESS)
        self._scene = SceneView(server)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(WIDTH)
        self.controls = Controls(server.gui, speed)
        self._panels = [self.controls, *self._make(panels or {})]
        self._next_poses = self._next_panels = 0.0

    @property
    def stopped(self) -> bool:
        """Whether the run was stopped from the page."""
        return self.controls.stopped

    def run_started(self, run: Any) -> None:
        """Show the name of the tree."""
        super().run_started(run)
        self.server.gui.set_panel_label(run.request.tree.name.rpartition("/")[2])
        for panel in self._panels:
            panel.start(run)

    def after_compile(self) -> None:
        """Add and remove the nodes of entities that came and went."""
        super().after_compile()
        cell = self._cell
        self._source = CellScene(cell.model, cell.data, cell.entities)
        self._scene.bind(self._source)

    def cycle_started(self, cycle: int) -> None:
        """Show what was randomized."""
        super().cycle_started(cycle)
        self._scene.bind(self._source)

    def before_tick(self) -> None:
        """Wait while the run is paused."""
        if self.controls.paused:
            self._refresh(now=True)
            self.controls.wait(self._refresh)

    def after_tick(self) -> None:
        """Update the page if the last update is old enough."""
        super().after_tick()
        for panel in self._panels:
            panel.end_tick()
        self._refresh()

    def run_ended(self) -> None:
        """Show the last state."""
        super().run_ended()
        self.controls.end()
        self._refresh(now=True)

    def wait(self, stop: Callable[[], bool]) -> None:
        """Serve the page until ``stop`` returns True."""
        while not stop():
            self._refresh()
            time.sleep(POSE_PERIOD)

    def close(self) -> None:
        """Stop the server."""
        close_server(self.server)

    # Internal

    def _compare_contacts(self) -> None:
        """Save the time: no panel shows contacts."""

    def _make(self, panels: Mapping[str, Callable[["Page"], Panel]]) -> Iterator[Panel]:
        """Yield new panels, each in a tab or in a folder above the tabs."""
        gui, tabs = self.server.gui, None
        for name, make in panels.items():
            label = name.replace("_", " ").capitalize()
            if not getattr(make, "in_tab", True):
                with gui.add_folder(label):
                    yield make(self)
                continue
            if tabs is None:
                tabs = gui.add_panel()
                tabs.dock_below(gui.main_panel)
            with tabs.add_tab(label):
                yield make(self)

    def _handle(self, event: RunEvent) -> None:
        for panel in self._panels:
            panel.handle(event)

    def _refresh(self, *, now: bool = False) -> None:
        time_now = time.perf_counter()
        if now or time_now >= self._next_poses:
            self._next_poses = time_now + POSE_PERIOD
            self._scene.update()
        if now or time_now >= self._next_panels:
            self._next_panels = time_now + PANEL_PERIOD
            for panel in self._panels:
                panel.draw()
