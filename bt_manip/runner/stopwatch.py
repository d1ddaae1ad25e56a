"""Find out whether a controller is slow, without changing what it does."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bt_manip.runner.observer import RunObserver

SLOW = 0.5
"""Share of a control step from which on a call is slow.

A controller is slow when most of its calls are: what a busy machine does to some does not count.
"""

WARM_UP = 10
"""Calls that do not count: the first ones of anything take longer."""


class Stopwatch(RunObserver):
    """Times a controller's ``compute`` through a run, and says at its end if it is slow.

    With several robots that is the controller of all that have the same one as the first.
    """

    def __init__(self, who: str, warn: Callable[[str], None]) -> None:
        """Watch a controller.

        Args:
            who: What to call it.
            warn: Takes the one line about one that is slow.
        """
        self._who, self._warn = who, warn
        self._calls = self._slow = 0
        self._busy = self._wall = 0.0  # [s]
        self._timed: list[tuple[Any, Any]] = []  # controllers, and what stands before them

    def run_started(self, run: Any) -> None:
        """Stand between the controllers and whoever calls them."""
        station = run.station
        self._dt = station.cell.dt
        for robot in station.robots.values():
            if type(robot.controller) is type(station.controller):
                self._watch(robot.controller)

    def _watch(self, controller: Any) -> None:
        compute, clock = controller.compute, time.perf_counter

        def timed(*arguments: np.ndarray) -> np.ndarray:
            start = clock()
            try:
                return compute(*arguments)
            finally:
                end = clock()
                self._calls += 1
                if self._calls == WARM_UP:
                    self._began = end
                elif self._calls > WARM_UP:
                    self._busy += end - start
                    self._slow += end - start > SLOW * self._dt
                    self._wall = end - self._began

        controller.compute = timed
        self._timed.append((controller, timed))

    def run_ended(self) -> None:
        """Step aside, and warn."""
        for controller, timed in self._timed:
            if vars(controller).get("compute") is timed:
                del controller.compute
        if not self._timed:
            return
        counted = self._calls - WARM_UP
        if 2 * self._slow <= max(counted, 0):
            return
        mean = self._busy / counted
        self._warn(
            f"{self._who} is slow: it takes {1e3 * mean:.2g} ms in each control step of "
            f"{1e3 * self._dt:g} ms ({mean / self._dt:.0%}), which is "
            f"{self._busy / self._wall:.0%} of the time that a step takes; the results are the same"
        )
