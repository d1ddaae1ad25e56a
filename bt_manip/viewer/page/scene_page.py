"""Common base of the page of a run and the page of a recording."""

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from bt_manip.runner import RunEvent

from .controls import Controls
from .panel import Panel
from .scene import SceneView
from .server import HOST, close_server, open_server, processor_time

POSE_PERIOD = 1.0 / 20.0
"""Wall time between two updates of the poses [s]."""

PANEL_PERIOD = 1.0 / 10.0
"""Wall time between two updates of the panels [s]."""

UPDATE_SHARE = 0.04
"""Largest share of wall time that updates take: more pages get fewer of them."""

LONGEST_PERIOD = 2.0
"""Longest wall time between two updates [s]."""

PANEL_WIDTH = 380
"""Width of the panels on the left and on the right [pixels]."""

MakePanel = Callable[[Any], Panel]
"""Makes a panel of a page; see the hook ``register_panels``."""


class ScenePage:
    """Scene, controls and panels in the browser; viser serves them in a thread of its own.

    Attributes:
        url: Address of the page.
        server: The ``viser.ViserServer``.
        controls: The controls.
    """

    def __init__(
        self, make_controls: Callable[[Any], Controls], panels: Mapping[str, MakePanel], port: int
    ) -> None:
        """Start the server.

        Args:
            make_controls: Makes the controls, of viser's ``GuiApi``.
            panels: Makers of the panels by name.
            port: The first port that is tried; 0 lets the system choose.
        """
        server = self.server = open_server(port)
        self.url = f"http://{HOST}:{server.get_port()}"
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.set_panel_label("bt-manip")
        self._scene = SceneView(server)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(PANEL_WIDTH)
        self.controls = make_controls(server.gui)
        self._panels: list[Panel] = [self.controls, *self._make(panels)]
        self._next = self._next_panels = self._served = 0.0

    def close(self) -> None:
        """Stop the server."""
        close_server(self.server)

    # For subclasses

    def _make(self, panels: Mapping[str, MakePanel]) -> Iterator[Panel]:
        """Yield new panels, each in a tab on the left or in a folder on the right."""
        gui, tabs = self.server.gui, None
        for name, make in panels.items():
            label = name.replace("_", " ").capitalize()
            if not getattr(make, "in_tab", True):
                with gui.add_folder(label):
                    yield make(self)
                continue
            if tabs is None:
                tabs = gui.add_panel()
                tabs.dock_left()
                tabs.set_width(PANEL_WIDTH)
            with tabs.add_tab(label):
                yield make(self)

    def _show_tree(self, name: str) -> None:
        """Show the name of the tree that runs, and forget the events of another run."""
        self.server.gui.set_panel_label(name.rpartition("/")[2])
        for panel in self._panels:
            panel.reset()

    def handle(self, event: RunEvent) -> None:
        """Hand an event to the panels."""
        for panel in self._panels:
            panel.handle(event)

    def _catch_up(self) -> None:
        """Bring scene and panels to the present state, before they are drawn."""

    def _refresh(self, *, now: bool = False) -> None:
        """Update scene and panels where the last update is old enough."""
        time_now = time.perf_counter()
        if not now and time_now < self._next:
            return
        start = time.thread_time()
        with self.server.atomic():  # wakes the server's thread once
            self._catch_up()
            self._scene.update()
            if now or time_now >= self._next_panels:
                self._next_panels = time_now + PANEL_PERIOD
                for panel in self._panels:
                    panel.draw()
        served, self._served = self._served, processor_time(self.server)
        used = time.thread_time() - start + self._served - served
        self._next = time_now + max(POSE_PERIOD, min(used / UPDATE_SHARE, LONGEST_PERIOD))
