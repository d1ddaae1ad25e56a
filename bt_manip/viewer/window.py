"""MuJoCo's own window onto a run."""

import threading
import time
from typing import Any

import mujoco

from bt_manip.runner import RunObserver
from bt_manip.viewer.display import require_display

REFRESH = 1.0 / 60.0
"""Wall time between two pictures [s]."""

CLOSING = 5.0
"""Wall time that the window may take to close [s]."""


class Window(RunObserver):
    """Shows the cell in MuJoCo's passive viewer, which draws in a thread of its own.

    The viewer gets a copy of the state, never the state itself: it steps and pushes what it has
    been given, and a run that is watched shall be the same run. Closing the window does not end
    the run.
    """

    def __init__(self) -> None:
        """Make sure that there is a display.

        Raises:
            NoDisplayError: When there is none.
        """
        require_display()
        self._handle: Any = None
        self._next = 0.0

    def run_started(self, run: Any) -> None:
        """Open the window."""
        import mujoco.viewer

        self._cell = run.station.cell
        self._data = _copy(self._cell)
        before = set(threading.enumerate())
        self._handle = mujoco.viewer.launch_passive(
            self._cell.model, self._data, show_left_ui=False, show_right_ui=False
        )
        self._threads = set(threading.enumerate()) - before

    def after_compile(self) -> None:
        """Hand the new model to the window that is open."""
        if self._handle is None or not self._handle.is_running():
            return
        self._data = _copy(self._cell)
        # The handle has no call for another model; the simulation behind it has.
        simulation = self._handle._sim()
        if simulation is not None:
            simulation.load(self._cell.model, self._data, "")

    def after_tick(self) -> None:
        """Show the present state, when it is time to."""
        now = time.perf_counter()
        if now < self._next or self._handle is None or not self._handle.is_running():
            return
        with self._handle.lock():
            mujoco.mj_copyData(self._data, self._cell.model, self._cell.data)
        self._handle.sync()
        self._next = now + REFRESH

    def run_ended(self) -> None:
        """Close the window."""
        handle, self._handle = self._handle, None
        if handle is None:
            return
        handle.close()
        # A thread that still draws while Python shuts down brings the process to a fall.
        for thread in self._threads:
            thread.join(CLOSING)


def _copy(cell: Any) -> mujoco.MjData:
    data = mujoco.MjData(cell.model)
    mujoco.mj_copyData(data, cell.model, cell.data)
    return data
