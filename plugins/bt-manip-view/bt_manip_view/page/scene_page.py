"""Common base of the page of a run and the page of a recording."""

import contextlib
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from .controls import Controls
from .findings import Findings
from .gui import Gui
from .panel import Panel
from .plot_panel import PLOT_SAMPLES
from .scene import SceneView
from .server import HOST, close_server, open_server
from .site import Site
from .viser_internals import connections

POSE_PERIOD = 1.0 / 20.0
"""Wall time between two updates of poses [s]; panels are drawn with each second one."""

UPDATE_SHARE = 0.04
"""Largest share of wall time for updates; where they take long, they are rarer."""

LONGEST_PERIOD = 1.0
"""Longest wall time between two updates [s]."""

MakePanel = Callable[[Any], Panel]
"""Factory of a panel of a page; see the hook ``register_panels``."""

P = TypeVar("P", bound=Panel)


class ScenePage:
    """Scene, controls and panels in the browser, served by a separate thread.

    Attributes:
        url: Address of the page.
        gui: The inputs and texts around the scene.
        bar: The container at the top.
        tabs: The container of the tabs.
        server: The ``viser.ViserServer`` of the scene.
        view: Shows the cell in the scene.
        shown_time: The displayed simulated time [s]; None: the present.
        findings: Findings of the check of the tree, at its nodes; a recording has none.
    """

    past: Any  # the states that can be shown: a History, or the Timeline of a recording

    def __init__(
        self, make_controls: Callable[[Any], Controls], panels: Mapping[str, MakePanel], port: int
    ) -> None:
        self.gui = Gui()
        self.shown_time: float | None = None
        self.findings: Findings = {}
        self.site = Site(self.gui)
        self.server = open_server(port, self.site)
        self.url = f"http://{HOST}:{self.server.get_port()}"
        self.view = SceneView(self.server)
        self._places = {name: self.gui.add(name) for name in ("bar", "left", "below", "over")}
        self.bar, self.tabs = self._places["bar"], self.gui.add("tabs")
        with self.bar:
            self.controls = make_controls(self.gui)
        self._panels: list[Panel] = [self.controls]
        self._present: list[Panel] = []  # those that do not follow the shown time
        self._wanted: float | None = None  # past time to show [s]
        self._index = -1  # number of the state that the others show
        self._entities: Mapping[str, Any] = {}  # that the scene shows of the past
        for name, make in panels.items():
            self._add_panel(name, make)
        self._next, self._has_drawn = 0.0, False

    def close(self) -> None:
        """Stop the server."""
        for panel in self._panels:
            panel.close()
        self.site.close()
        close_server(self.server)

    @property
    def is_open(self) -> bool:
        """Whether any browser shows the page."""
        return self.site.is_open or bool(connections(self.server))

    @property
    def span(self) -> tuple[float, float | None]:
        """Times of start and end of the past that can be shown [s]; no end while a run goes on."""
        return float(self.past.times[0]), float(self.past.times[-1])

    def show_time(self, time: float | None) -> None:
        """Show another simulated time in all browsers [s]; None: the present."""
        self._wanted = time

    def refresh(self, *, now: bool = False) -> None:
        """Update the scene where the last update is old enough, or at once (`now`)."""
        if not now and time.perf_counter() < self._next:
            return
        start = time.thread_time()
        with self.server.atomic():  # wakes the server's thread once
            self._catch_up()
            self.view.update()
            self._has_drawn = now or not self._has_drawn
            if self._has_drawn:
                for panel in self._panels:
                    panel.draw()
                with contextlib.suppress(RuntimeError):  # the server is being stopped
                    self.server.get_event_loop().call_soon_threadsafe(self.site.publish)
        used = time.thread_time() - start
        period = max(POSE_PERIOD, min(used / UPDATE_SHARE, LONGEST_PERIOD))
        self._next = time.perf_counter() + period

    # For subclasses

    def _add_panel(self, name: str, make: Callable[[Any], P]) -> P:
        """Add a panel in its container; return it."""
        container = self._places.get(getattr(make, "place", Panel.place))
        if container is None:
            with self.tabs:
                container = self.gui.add("tab", label=name.replace("_", " ").capitalize())
        with container:
            self._panels.append(panel := make(self))
        if getattr(make, "needs_run", False) or getattr(make, "whole_run", False):
            self._present.append(panel)
        return panel

    def _show_tree(self, name: str) -> None:
        """Show the name of the running tree, and clear the panels."""
        self.controls.task = name.rpartition("/")[2]
        for panel in self._panels:
            panel.reset()

    def _go_to(self, index: int) -> None:
        """Bring the scene, and the panels that follow the shown time, to a state of the past."""
        past, before = self.past, self._index
        following = [panel for panel in self._panels if panel not in self._present]
        if index < before:
            before = -1
            for panel in following:
                panel.reset()
        for event in past.events(before, index):
            for panel in following:
                panel.handle(event)
        self._sample(max(before + 1, index + 1 - PLOT_SAMPLES), index + 1, following)
        self._index = past.scene.index = index
        if self._entities != (present := past.scene.entities()):
            self._entities = present
            self.view.bind(past.scene)

    def _sample(self, first: int, end: int, panels: Iterable[Panel]) -> None:
        """Give panels the states from ``first`` to before ``end``; state 0 has no samples."""
        if (first := max(first, 1)) < end:
            times, joints = self.past.joints(first, end)
            for panel in panels:
                panel.sample(times, joints)

    def _catch_up(self) -> None:
        """Bring scene and panels to the present state before drawing."""
