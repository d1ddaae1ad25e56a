"""Measuring the computing time of controllers during a run."""

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .observer import RunObserver

if TYPE_CHECKING:
    from .run import Run

SLOW = 0.5
"""Fraction of the control step beyond which a call is slow.

A controller is slow if most of its calls are: single calls may be slow on a busy machine.
"""

WARM_UP = 10
"""First calls of a controller, which take longer and are not counted."""


class Stopwatch(RunObserver):
    """Measures the wall time of ``compute`` of the active controllers, and warns of slow ones.

    Args:
        labels: The controllers to measure: how a warning calls them, by registered name.
        warn: Takes one line for each slow controller.
    """

    def __init__(self, labels: Mapping[str, str], warn: Callable[[str], None]) -> None:
        self._labels, self._warn = labels, warn
        self._timings: dict[str, _Timing] = {}
        self._timed: list[tuple[Any, Any]] = []  # controllers, and the replaced compute

    def run_started(self, run: "Run") -> None:
        """Measure the controllers that are active first."""
        self._dt = run.station.cell.dt
        self._managers = [robot.controllers for robot in run.station.robots.values()]
        self.after_tick()

    def after_tick(self) -> None:
        """Measure the controllers that the tree has switched to."""
        for manager in self._managers:
            controller = manager.controller
            if manager.active in self._labels and all(controller is not c for c, _ in self._timed):
                timing = self._timings.setdefault(manager.active, _Timing(SLOW * self._dt))
                controller.compute = timed = timing.around(controller.compute)  # type: ignore[method-assign]
                self._timed.append((controller, timed))

    def run_ended(self) -> None:
        """Stop measuring, and warn."""
        for controller, timed in self._timed:
            if vars(controller).get("compute") is timed:
                del controller.compute
        for name, timing in self._timings.items():
            if 2 * timing.slow > max(timing.counted, 0):  # most calls
                mean = timing.busy / timing.counted
                self._warn(
                    f"{self._labels[name]} is slow: it takes {1e3 * mean:.2g} ms in each control "
                    f"step of {1e3 * self._dt:g} ms ({mean / self._dt:.0%}), which is "
                    f"{timing.busy / timing.wall:.0%} of the time that a step takes; the results "
                    "are the same"
                )


class _Timing:
    """The calls of one controller.

    Attributes:
        counted: Number of calls after the warm-up.
        slow: Number of slow ones of them.
        busy: Their wall time [s].
        wall: Wall time since the warm-up [s].
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self.counted, self.slow, self.busy, self.wall = -WARM_UP, 0, 0.0, 0.0

    def around(self, compute: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
        """Return a function that calls another one and measures the call."""
        clock = time.perf_counter

        def timed(*arguments: np.ndarray) -> np.ndarray:
            start = clock()
            try:
                return compute(*arguments)
            finally:
                end = clock()
                self.counted += 1
                if self.counted == 0:
                    self._began = end
                elif self.counted > 0:
                    self.busy += end - start
                    self.slow += end - start > self._limit
                    self.wall = end - self._began

        return timed
