"""A plot of the tracking errors of the arms."""

import time
from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np

from .panel import Panel

PLOT_SAMPLES = 1000
"""Number of ticks that are shown."""

PLOT_PERIOD = 0.5
"""Wall time between two updates of the plot, which is sent whole [s]."""

LINE_COLOURS = ("#1971c2", "#e67700", "#2b8a3e", "#9c36b5")
"""Colours of the robots."""


class ErrorPlot(Panel):
    """Plots the largest joint tracking error of each robot after each tick."""

    def __init__(self, page: Any) -> None:
        """Keep the container; the plot is added when the robots are known."""
        self._gui = page.server.gui
        self._container = self._gui.add_folder("Tracking error [mrad]")
        self._plot: Any = None
        self._names: list[str] = []
        self.reset()

    def reset(self) -> None:
        """Forget the samples."""
        self._samples: deque[tuple[Any, ...]] = deque(maxlen=PLOT_SAMPLES)
        self._changed, self._next = True, 0.0

    def sample(
        self, times: np.ndarray, joints: Mapping[str, tuple[np.ndarray, np.ndarray]]
    ) -> None:
        """Sample the errors; the first sample of other robots makes another plot."""
        if list(joints) != self._names:
            self._names = list(joints)
            self._samples.clear()
            self._add_plot()
        errors = [1e3 * np.abs(q - q_ref).max(axis=1) for q, q_ref in joints.values()]
        self._samples.extend(zip(times, *errors, strict=True))
        self._changed = True

    def draw(self) -> None:
        """Send the plot if it has changed and the last one is old enough."""
        now = time.perf_counter()
        if self._plot is not None and self._changed and now >= self._next:
            self._changed, self._next = False, now + PLOT_PERIOD
            samples = np.array(self._samples).reshape(-1, 1 + len(self._names))
            self._plot.data = tuple(samples.T.copy())

    def _add_plot(self) -> None:
        if self._plot is not None:
            self._plot.remove()
        series = [
            {"label": name, "stroke": LINE_COLOURS[i % len(LINE_COLOURS)], "width": 1.5}
            for i, name in enumerate(self._names)
        ]
        with self._container:
            self._plot = self._gui.add_uplot(
                tuple(np.zeros(1) for _ in range(1 + len(series))),
                ({"label": "t [s]"}, *series),
                scales={"x": {"time": False}},
                height=180,
            )
