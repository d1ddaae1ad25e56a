"""Perturbation of an object by a handle in the scene."""

from functools import partial
from typing import Any

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.runner import MAX_FORCE, Run, Station

from .lines import NO_LINES, Lines
from .panel import HANDLE_SIZE, Panel

NO_OBJECT = "none"
"""Option for no object."""

FORCES = (1.0, 100.0)
"""Range of the maximum force [N]."""

PULL_COLOUR = (230, 119, 0)
"""Colour of the line from the object to the handle."""


class PerturbationPanel(Panel):
    """Pulls the selected object towards its handle by a limited spring force while it is dragged.

    Callbacks only set the target; the thread of the run requests the intervention.
    """

    needs_run = True

    def __init__(self, page: Any) -> None:
        gui, self._page, self._scene = page.gui, page, page.server.scene
        self._choice = gui.add_dropdown(
            "Object", (NO_OBJECT,), hint="Or click it in the scene, then drag its handle to pull it"
        )
        self._force = gui.add_slider(
            "Maximum force [N]", *FORCES, 1.0, MAX_FORCE, hint="Limit of the spring force"
        )
        self._run: Any = None
        self._handle: Any = None
        self._line = Lines(self._scene, "/pull", PULL_COLOUR)
        self._target: list[float] | None = None  # position of the dragged handle [m]
        self._pulled: tuple[str, list[float], float] | None = None  # the last request

    def start(self, run: Run) -> None:
        """Prepare to pull objects of the run's cell."""
        self._run, self._pulled = run, None

    def begin_idle(self, station: Station) -> None:
        """Remove the handle: only a run can be perturbed."""
        self._run = None
        self._remove()

    def reset(self) -> None:
        """Release the object."""
        self._target = None

    def end_tick(self) -> None:
        """Request a perturbation if the handle was moved, or released."""
        target, name, force = self._target, self._choice.value, float(self._force.value)
        wanted = None if target is None or name == NO_OBJECT else (name, target, force)
        if wanted == self._pulled:
            return
        pull, before, self._pulled = self._run.interventions.pull, self._pulled, wanted
        try:
            if before is not None and (wanted is None or before[0] != name):
                pull(before[0], None)
            if wanted is not None:
                pull(name, target, max_force=force)
        except BtManipError:  # the object was removed, or the page sent a malformed message
            self._target = None

    def draw(self) -> None:
        """Move handle and line to the selected object."""
        if self._run is None:
            return
        if self._page.shown_time is not None:  # the past cannot be pulled
            self._remove()
            return
        movable = tuple(filter(self._is_movable, self._cell.entities))
        self._choice.options = (NO_OBJECT, *movable)
        for name in movable:  # those that were added since the last time
            self._page.view.on_click(name, partial(self._choose, name))
        name = self._choice.value
        if name == NO_OBJECT or name not in self._cell.entities:
            self._remove()
            return
        position = self._cell.data.xpos[self._cell.body_id(name)].copy()
        if self._handle is None:
            self._handle = self._scene.add_transform_controls(
                "/handle", HANDLE_SIZE, disable_rotations=True, depth_test=False, position=position
            )
            self._handle.on_update(self._dragged)
        target = self._target
        if target is not None:
            self._line.show(np.array([[position, target]]))
        else:
            self._line.show(NO_LINES)
            if np.abs(self._handle.position - position).max() > 1e-4:
                self._handle.position = position

    # Internal

    @property
    def _cell(self) -> Any:
        return self._run.station.cell

    def _is_movable(self, name: str) -> bool:
        cell = self._cell
        fixed = cell.model.body_weldid[cell.body_id(name)] == 0
        return not fixed and name not in self._run.station.robots

    def _remove(self) -> None:
        self._target = None
        self._line.show(NO_LINES)
        if self._handle is not None:
            self._handle.remove()
            self._handle = None

    # Callbacks; viser calls async ones in the order of the messages

    def _choose(self, name: str) -> None:
        self._choice.value = name

    async def _dragged(self, event: Any) -> None:  # a closed page ends the drag
        self._target = None if event.phase == "end" else event.target.position.tolist()
