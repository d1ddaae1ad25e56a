"""Control steps that wait to be evaluated together."""

from typing import Any, NamedTuple

import numpy as np

SIZE = 256
"""Steps in a block: enough that evaluating it costs a step next to nothing."""


class Block(NamedTuple):
    """Control steps, one a row; only valid until the log is written to again."""

    t: np.ndarray  # (n,) [s]
    q: np.ndarray  # (n, nq)
    v: np.ndarray  # (n, nq)
    q_ref: np.ndarray  # (n, nq)
    v_ref: np.ndarray  # (n, nq)
    a_ref: np.ndarray  # (n, nq)
    tau: np.ndarray  # (n, nq)
    tool: np.ndarray  # (n, 3)
    touches: list[Any]  # (n,) bt_manip.cell.touch.Touch


class StepLog:
    """Copies the state after each control step into rows that were allocated before.

    This runs a thousand times in a simulated second, so it only copies: what comes from the
    physics is read through views that are bound once for a compiled model.
    """

    def __init__(self, station: Any) -> None:
        """Allocate the rows and look at a station's present model.

        Args:
            station: The cell with its robot, arm and controller.
        """
        self._station = station
        nq = len(station.robot.limits.lower)
        self._t = np.empty(SIZE)
        self._q, self._v, self._q_ref, self._v_ref, self._a_ref, self._tau = np.empty((6, SIZE, nq))
        self._tool = np.empty((SIZE, 3))
        self._touches: list[Any] = []
        self.bind()

    def bind(self) -> None:
        """Look at the model that the cell has now."""
        station = self._station
        cell, robot = station.cell, station.robot
        self._data = cell.data
        self._judge = cell.touch.judge
        self._arm, self._controller = station.arm, station.controller
        self._q_now = _view(cell.data.qpos, robot.qpos_adr)
        self._v_now = _view(cell.data.qvel, robot.dof_adr)
        self._qpos_adr = None if self._q_now is not None else np.asarray(robot.qpos_adr)
        self._dof_adr = None if self._v_now is not None else np.asarray(robot.dof_adr)
        self._tool_now = cell.data.site_xpos[robot.tool_site_id]

    def append(self) -> bool:
        """Copy the state after one step; tell whether the block is full."""
        i = len(self._touches)
        data, arm, controller = self._data, self._arm, self._controller
        self._t[i] = data.time
        self._q[i] = self._q_now if self._q_now is not None else data.qpos[self._qpos_adr]
        self._v[i] = self._v_now if self._v_now is not None else data.qvel[self._dof_adr]
        self._q_ref[i] = arm.q
        self._v_ref[i] = arm.v
        self._a_ref[i] = arm.a
        self._tau[i] = controller.tau
        self._tool[i] = self._tool_now
        self._touches.append(self._judge())
        return i + 1 == SIZE

    def take(self) -> Block:
        """Give the steps since the last call and begin a new block."""
        touches, self._touches = self._touches, []
        n = len(touches)
        return Block(
            self._t[:n], self._q[:n], self._v[:n], self._q_ref[:n], self._v_ref[:n],
            self._a_ref[:n], self._tau[:n], self._tool[:n], touches,
        )  # fmt: skip


def _view(array: np.ndarray, addresses: Any) -> np.ndarray | None:
    """Give a view of some elements where they stand in a row, as an arm's joints mostly do."""
    first, n = int(addresses[0]), len(addresses)
    if list(addresses) == list(range(first, first + n)):
        return array[first : first + n]
    return None
