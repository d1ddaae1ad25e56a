"""The targets that a configuration has to meet, stacked."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .rows import Rows


class System:
    """Errors and Jacobian of several targets at one configuration.

    Attributes:
        rows: The targets' errors.
        q: The configuration last looked at.  # (nq,)
    """

    def __init__(
        self, arm: RobotModel, rows: Sequence[Rows], moving: np.ndarray | None = None
    ) -> None:
        """Stack targets.

        Args:
            arm: The arm; its data are written to.
            rows: The targets' errors.
            moving: Which joints may move; by default all.  # (nv,)
        """
        self._model, self._data = arm.model, arm.data
        self.rows = tuple(rows)
        self._only = self.rows[0] if len(self.rows) == 1 else None
        self._moving = moving
        self.q: np.ndarray | None = None

    def look(self, q: np.ndarray) -> np.ndarray:
        """Measure all errors at a configuration."""  # (m,)
        pin.computeJointJacobians(self._model, self._data, q)
        self.q = q
        if self._only is not None:
            return self._only.measure()
        return np.concatenate([row.measure() for row in self.rows] or [np.zeros(0)])

    @property
    def near(self) -> float:
        """The square of the error above which not all targets can be met."""
        return sum([row.near for row in self.rows])

    @property
    def met(self) -> bool:
        """Whether all targets are met where the errors were measured last."""
        return all([row.met for row in self.rows])

    def jacobian(self) -> np.ndarray:
        """Give J of ``d error = J dq`` where the errors were measured last."""  # (m, nv)
        if self._only is not None:
            jacobian = self._only.jacobian()
        else:
            empty = np.zeros((0, self._model.nv))
            jacobian = np.vstack([row.jacobian() for row in self.rows] or [empty])
        return jacobian if self._moving is None else jacobian * self._moving
