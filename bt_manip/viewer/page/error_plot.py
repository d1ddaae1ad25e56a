"""A plot of the tracking errors of the arms."""

import time
from collections import deque
from typing import Any

import numpy as np

from .panel import Panel

SAMPLES = 1000
"""Number of ticks that are shown."""

PLOT_PERIOD = 0.5
"""Wall time between two updates of the plot, which is sent whole [s]."""

LINE_COLOURS = ("#1971c2", "#e67700", "#2b8a3e", "#9c36b5")
"""Colours of the robots."""


class ErrorPlot(Panel):
    """Plots the largest joint tracking error of each robot after each tick."""

    def __init__(self, page: Any) -> None:
        """Keep the container; the plot is added when the robots are known.

        Args:
            page: The page.
        """
        self._gui = page.server.gui
        self._container = self._gui.add_folder("Tracking error [mrad]")
        self._plot: Any = None
        self._samples: deque[tuple[float, ...]] = deque(maxlen=SAMPLES)
        self._next = 0.0

    def start(self, run: Any) -> None:
        """Add the plot."""
        self._cell, self._robots = run.station.cell, list(run.station.robots.values())
        series = [
            {"label": robot.name, "stroke": LINE_COLOURS[i % len(LINE_COLOURS)], "width": 1.5}
            for i, robot in enumerate(self._robots)
        ]
        with self._container:
            self._plot = self._gui.add_uplot(
                tuple(np.zeros(1) for _ in range(1 + len(series))),
                ({"label": "t [s]"}, *series),
                scales={"x": {"time": False}},
                height=180,
            )

    def end_tick(self) -> None:
        """Sample the errors."""
        errors = [float(np.abs(one.robot.q - one.arm.q).max()) * 1e3 for one in self._robots]
        self._samples.append((self._cell.time, *errors))

    def draw(self) -> None:
        """Send the plot if the last one is old enough."""
        now = time.perf_counter()
        if self._samples and now >= self._next:
            self._next = now + PLOT_PERIOD
            self._plot.data = tuple(np.array(self._samples).T.copy())
