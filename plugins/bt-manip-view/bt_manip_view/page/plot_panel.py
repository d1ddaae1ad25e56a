"""Plots of quantities over time."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bt_manip.runner import Run, RunEvent

from .gui import GuiElement, GuiEvent, rows_of
from .panel import Panel
from .quantities import MAX_TICKS, TRACKING_ERROR, LiveQuantities, RecordedQuantities

PLOT_SAMPLES = 1000
"""Largest number of ticks that panels get at once."""

LINE_COLOURS = ("#1971c2", "#e67700", "#2b8a3e", "#9c36b5")
"""Colours of the robots."""

ADD = "add a plot"
"""Option of the list that adds nothing."""


class PlotPanel(Panel):
    """Plots quantities below each other; a list adds plots, and each can be removed.

    Of a run it shows the last minute, of a recording all of it, whatever time the page shows.
    """

    whole_run = True

    def __init__(self, page: Any) -> None:
        self._page, self._gui = page, page.gui
        self._recorded: RecordedQuantities | None = getattr(page, "quantities", None)
        self._live: LiveQuantities | None = None
        self._chosen: dict[str, None] = {TRACKING_ERROR: None}
        self._list = page.gui.add_dropdown("Quantity", (ADD,), hint="Adds a plot")
        self._list.on_update(self._add)
        self._container = page.gui.add_folder("")
        self._plots: dict[str, _Plot] = {}

    def start(self, run: Run) -> None:
        """Sample the quantities of a run."""
        self._live = LiveQuantities(run, lambda: self._page.controls.time)

    def reset(self) -> None:
        """Forget the samples of a run."""
        self._live = None
        while self._plots:
            self._plots.popitem()[1].remove()

    def handle(self, event: RunEvent) -> None:
        """Store a number of the blackboard."""
        if self._live is not None:
            self._live.handle(event)

    def sample(
        self, times: np.ndarray, joints: Mapping[str, tuple[np.ndarray, np.ndarray]]
    ) -> None:
        """Store positions and tracking errors."""
        if self._live is not None:
            self._live.add_joints(times, joints)

    def end_tick(self) -> None:
        """Sample the quantities."""
        if self._live is not None:
            self._live.sample()

    def draw(self) -> None:
        """Add and remove plots, and send new samples."""
        quantities, chosen = self._live or self._recorded, list(self._chosen)
        for name in [name for name in self._plots if name not in chosen]:
            self._plots.pop(name).remove()
        if quantities is None:
            return
        known = quantities.names()
        self._list.options = (ADD, *(name for name in known if name not in chosen))
        for name in chosen:
            if name in known:
                if name not in self._plots:
                    self._plots[name] = _Plot(self._gui, self._container, name, self._remove)
                self._plots[name].draw(quantities)

    # Callbacks

    def _add(self, event: GuiEvent) -> None:
        if event.value != ADD:
            self._chosen[event.value] = None
            self._list.value = ADD

    def _remove(self, name: str) -> None:
        self._chosen.pop(name, None)


class _Plot:
    """The plot of a quantity, made anew when the quantity gets another line."""

    def __init__(self, gui: Any, container: GuiElement, name: str, remove: Any) -> None:
        self._gui, self._container, self._name, self._remove = gui, container, name, remove
        self._element: GuiElement | None = None
        self._last = -np.inf

    def remove(self) -> None:
        """Remove the plot from the page."""
        if self._element is not None:
            self._element.remove()
            self._element = None

    def draw(self, quantities: LiveQuantities | RecordedQuantities) -> None:
        """Send the samples since the last call."""
        unit, labels, rows = quantities.table(self._name, self._last)
        if self._element is not None and not len(rows):
            return
        if self._element is None or labels != self._element.names:
            unit, labels, rows = quantities.table(self._name)
            self.remove()
            with self._container:
                self._element = self._gui.add_plot(self._name, unit, labels, removable=True)
            self._element.samples = rows_of(rows)
            self._element.on("remove", lambda _: self._remove(self._name))
        else:
            self._element.append("samples", rows_of(rows), MAX_TICKS)
        if len(rows):
            self._last = float(rows[-1, 0])
