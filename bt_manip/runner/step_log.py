"""Buffer of control steps, evaluated in blocks."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bt_manip.cell import Cell
from bt_manip.robots import reader

from .commanded_robot import CommandedRobot

join = b"".join

SIZE = 512
"""Steps in a block: large enough that the evaluation costs little per step."""


STEP_FIELDS = ("q", "v", "q_ref", "v_ref", "a_ref", "tau")
"""Fields of a `StepBlock` with one number per joint; ``*_ref`` is the arm's reference."""


class StepBlock(NamedTuple):
    """Control steps, one per row."""

    t: np.ndarray  # (n,) [s]
    q: np.ndarray  # (n, nq)
    v: np.ndarray  # (n, nq)
    q_ref: np.ndarray  # (n, nq)
    v_ref: np.ndarray  # (n, nq)
    a_ref: np.ndarray  # (n, nq)
    tau: np.ndarray  # (n, nq)
    tool: np.ndarray  # (n, 3)
    touches: list[Any]  # (n,) bt_manip.cell.ContactSummary

    def part(self, start: int, end: int) -> "StepBlock":
        """Return the steps from ``start`` to before ``end``."""
        rows: Any = (column[start:end] for column in self)
        return StepBlock(*rows)


class PendingSteps(NamedTuple):
    """Growing lists of copied control steps."""

    times: list[float]
    """Simulated times [s]."""
    rows: list[bytes]
    """The arrays of `StepBlock` from ``q`` to ``tool``."""
    touches: list[Any]
    """Their `bt_manip.cell.ContactSummary`."""


class StepLog:
    """Copies the state of a robot after each control step.

    It runs in every control step, so it only copies. Quantities of the physics are read through
    views that are bound once per compiled model. A step is joined as bytes, which takes a fifth of
    the time of writing rows of an array.

    Args:
        cell: The `bt_manip.cell.Cell`.
        commanded: The `bt_manip.runner.CommandedRobot` in it.

    Attributes:
        pending: The steps since the last `take`. Another thread may read them: a step is complete
            when its contacts are there.
        readers: Called by `take` with the pending steps.
    """

    def __init__(self, cell: Cell, commanded: CommandedRobot) -> None:
        self._cell, self._robot = cell, commanded.robot
        self._arm, self._controllers = commanded.arm, commanded.controllers
        self._nq = len(self._robot.limits.lower)
        self.pending = PendingSteps([], [], [])
        self.readers: list[Callable[[PendingSteps], None]] = []
        self.bind()

    def bind(self) -> None:
        """Bind to the current model of the cell."""
        cell, robot = self._cell, self._robot
        data, arm = cell.data, self._arm
        # In one tuple, because looking up attributes one by one takes as long as the copy.
        self._bound = (
            reader(data.qpos, robot.qpos_adr), reader(data.qvel, robot.dof_adr), arm.q, arm.v,
            arm.a, self._controllers, data.site_xpos[robot.tool_site_id], data,
            cell.contact_monitor.summary,
        )  # fmt: skip

    def append(self) -> bool:
        """Copy the state after one step; return whether the block is full."""
        q, v, q_ref, v_ref, a_ref, controllers, tool, data, judge = self._bound
        parts: Any = (q(), v(), q_ref, v_ref, a_ref, controllers.controller.tau, tool)
        times, rows, touches = self.pending
        rows.append(join(parts))
        times.append(data.time)
        touches.append(judge())
        return len(touches) >= SIZE

    def take(self) -> StepBlock:
        """Return the steps since the last call and start a new block."""
        for read in self.readers:
            read(self.pending)
        times, copies, touches = self.pending
        self.pending = PendingSteps([], [], [])
        n, nq = len(touches), self._nq
        rows = np.frombuffer(b"".join(copies[:n])).reshape(n, 6 * nq + 3)
        q, v, q_ref, v_ref, a_ref, tau, tool = np.split(rows, range(nq, 6 * nq + 1, nq), axis=1)
        t = np.array(times[:n])
        return StepBlock(t, q, v, q_ref, v_ref, a_ref, tau, tool, touches)
