"""Plot of the tracking errors of the arms."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from .gui import rows_of
from .panel import Panel

PLOT_SAMPLES = 1000
"""Number of plotted ticks."""

LINE_COLOURS = ("#1971c2", "#e67700", "#2b8a3e", "#9c36b5")
"""Colours of the robots."""


class ErrorPlot(Panel):
    """Plots the largest joint tracking error of each robot after each tick."""

    def __init__(self, page: Any) -> None:
        self._gui = page.gui
        self._container = page.gui.add_folder("")
        self._plot: Any = None
        self._names: list[str] = []
        self._new: list[np.ndarray] = []

    def reset(self) -> None:
        """Forget the samples."""
        self._new.clear()
        if self._plot is not None:
            self._plot.samples = []

    def sample(
        self, times: np.ndarray, joints: Mapping[str, tuple[np.ndarray, np.ndarray]]
    ) -> None:
        """Add the errors; a change of robots starts a new plot."""
        if list(joints) != self._names:
            self._names = list(joints)
            self._new.clear()
            if self._plot is not None:
                self._plot.remove()
            with self._container:
                self._plot = self._gui.add_plot("Tracking error", "mrad", self._names)
        errors = [1e3 * np.abs(q - q_ref).max(axis=1) for q, q_ref in joints.values()]
        self._new.append(np.column_stack([times, *errors]))

    def draw(self) -> None:
        """Send the new samples."""
        if self._new:
            rows = np.concatenate(self._new)[-PLOT_SAMPLES:]
            self._plot.append("samples", rows_of(rows), PLOT_SAMPLES)
            self._new.clear()
