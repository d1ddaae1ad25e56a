"""MuJoCo's desktop viewer of a run."""

import threading
import time
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from bt_manip.cell import OVERVIEW, Cell
from bt_manip.runner import Run, RunObserver
from bt_manip.viewer.display import require_display

FRAME_PERIOD = 1.0 / 60.0
"""Wall time between two frames [s]."""

CLOSING_TIME = 5.0
"""Longest wall time to wait for the viewer's thread [s]; drawing in software takes seconds."""

FREE_CAMERA = (-125.0, -20.0)
"""Initial azimuth and elevation of the view without a camera `OVERVIEW` [deg]."""


class Window(RunObserver):
    """Shows the cell in MuJoCo's passive viewer, which draws in its own thread.

    The viewer writes to its data, so it gets a copy of the state: a window does not change the run.
    Closing the window does not end the run. After the run it stays open until `close`.

    Raises:
        NoDisplayError: If no display is available.
    """

    def __init__(self) -> None:
        require_display()
        self._handle: Any = None
        self._threads: set[threading.Thread] = set()
        self._next = 0.0

    @property
    def is_open(self) -> bool:
        """Whether the window is open."""
        return self._handle is not None and bool(self._handle.is_running())

    def run_started(self, run: Run) -> None:
        """Open the window."""
        import mujoco.viewer

        self._cell = run.station.cell
        self._data = _copy(self._cell)
        before = set(threading.enumerate())
        self._handle = mujoco.viewer.launch_passive(
            self._cell.model, self._data, show_left_ui=False, show_right_ui=False
        )
        self._threads = set(threading.enumerate()) - before
        with self._handle.lock():
            aim(self._handle.cam, self._cell.model, self._data)
        self._handle.sync()

    def after_compile(self) -> None:
        """Show the new model from the same viewpoint."""
        if not self.is_open:
            return
        self._data = _copy(self._cell)
        camera = self._handle.cam
        viewpoint = camera.lookat.copy(), camera.distance, camera.azimuth, camera.elevation
        # Only the simulation behind the handle can load another model.
        simulation = self._handle._sim()
        if simulation is not None:
            simulation.load(self._cell.model, self._data, "")
            with self._handle.lock():
                camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = viewpoint

    def after_tick(self) -> None:
        """Show the present state if the last frame is `FRAME_PERIOD` old.

        Where drawing is slow, frames are dropped: drawing takes at most a fifth of the wall time.
        """
        before = time.perf_counter()
        if before >= self._next and self.is_open:
            self._show()
            after = time.perf_counter()
            self._next = after + max(FRAME_PERIOD, 4.0 * (after - before))

    def run_ended(self) -> None:
        """Show the last state."""
        if self.is_open:
            self._show()

    def wait_until_closed(self, stop: Callable[[], bool]) -> None:
        """Keep the window open until the user closes it or ``stop`` returns True."""
        while self.is_open and not stop():
            time.sleep(FRAME_PERIOD)

    def close(self) -> None:
        """Close the window."""
        handle, self._handle = self._handle, None
        if handle is None:
            return
        handle.close()
        # A thread that still draws while Python shuts down crashes the process.
        for thread in self._threads:
            thread.join(CLOSING_TIME)

    def _show(self) -> None:
        with self._handle.lock():
            mujoco.mj_copyData(self._data, self._cell.model, self._cell.data)
        self._handle.sync()


def aim(camera: mujoco.MjvCamera, model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Aim a free camera at the centre of a model, from a distance that shows all of it.

    Direction and distance are those of the camera `OVERVIEW`, if the model has one. The state of
    the model is that after ``mj_forward``.
    """
    mujoco.mjv_defaultFreeCamera(model, camera)
    camera.azimuth, camera.elevation = FREE_CAMERA
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, OVERVIEW)
    if number < 0:
        return
    forward = -data.cam_xmat[number].reshape(3, 3)[:, 2]
    depth = float(forward @ (model.stat.center - data.cam_xpos[number]))
    if depth > 0.0:
        camera.lookat[:] = data.cam_xpos[number] + depth * forward
        # The field of view of the free camera differs: show the same height of the scene.
        halves = np.deg2rad([model.cam_fovy[number], model.vis.global_.fovy]) / 2.0
        camera.distance = depth * np.tan(halves[0]) / np.tan(halves[1])
        camera.azimuth = np.rad2deg(np.arctan2(forward[1], forward[0]))
        camera.elevation = np.rad2deg(np.arcsin(np.clip(forward[2], -1.0, 1.0)))


def _copy(cell: Cell) -> mujoco.MjData:
    data = mujoco.MjData(cell.model)
    mujoco.mj_copyData(data, cell.model, cell.data)
    return data
