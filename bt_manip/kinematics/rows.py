"""Errors of frames from their targets, with their Jacobians.

Each kind has `measure`, to be called after `pin.computeJointJacobians`, and `jacobian`, the matrix
J of ``d error = J dq``.
"""

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

WIDE = 1e-3  # [m] and [rad] from which a tolerance is room to move in
AIM = 0.9  # of a wide tolerance, that an error outside is brought back to
_ROUND = 1.0 + 1e-9  # against rounding


class Rows:
    """What all kinds have in common.

    Attributes:
        frame: Index of the frame.
        tolerance: Largest error that meets the target.
        near: The square of the error above which the target cannot be met.
    """

    near: float

    def __init__(self, arm: RobotModel, frame: int, tolerance: float) -> None:
        """Look at a frame.

        Args:
            arm: The arm; its data are written to.
            frame: The frame's index.
            tolerance: Largest error that meets the target.
        """
        self._model, self._data, self.frame = arm.model, arm.data, frame
        self.tolerance = tolerance

    @property
    def met(self) -> bool:
        """Whether the target is met where the error was measured last."""
        return self.residual()[2]

    def residual(self) -> tuple[float, float, bool]:
        """Give distance [m] and angle [rad], 0 where there is none, and whether both will do.

        They are those that were measured last.
        """
        raise NotImplementedError

    def measure(self) -> np.ndarray:
        """Measure the error."""  # (size,)
        raise NotImplementedError

    def jacobian(self) -> np.ndarray:
        """Give the Jacobian where the error was measured last."""  # (size, nv)
        raise NotImplementedError


class ScaledRows(Rows):
    """An error of three components that has a weight, or room within a wide tolerance."""

    def __init__(self, arm: RobotModel, frame: int, tolerance: float, scale: float) -> None:
        """Look at a frame.

        Args:
            arm: The arm; its data are written to.
            frame: The frame's index.
            tolerance: Largest error that meets the target.
            scale: Root of the weight; 1 for a constraint.
        """
        super().__init__(arm, frame, tolerance)
        self._scale = scale
        self._room = AIM * tolerance if WIDE <= tolerance < np.inf else 0.0
        self.near = (tolerance - self._room) ** 2 * _ROUND
        self._length = 0.0

    def _outside(self, error: np.ndarray) -> np.ndarray:
        """Leave of an error what is outside the room that a wide tolerance gives."""
        self._whole = error
        self._length = length = float(error.dot(error)) ** 0.5
        if self._room:
            return error * max(0.0, 1.0 - self._room / max(length, self._room))
        return self._scale * error

    def _of_outside(self, jacobian: np.ndarray) -> np.ndarray:
        """Turn the Jacobian of an error into that of what is left of it."""
        room, length = self._room, self._length
        if not room:
            return self._scale * jacobian
        if length <= room:
            return np.zeros_like(jacobian)
        along = self._whole / length
        return (1.0 - room / length) * jacobian + room / length * np.outer(along, along @ jacobian)


class PositionRows(ScaledRows):
    """From a place to the origin of a frame, in the world's axes."""

    def __init__(
        self, arm: RobotModel, frame: int, place: np.ndarray, tolerance: float, scale: float = 1.0
    ) -> None:
        """Look at a frame that shall be at a place [m]."""  # (3,)
        super().__init__(arm, frame, tolerance, scale)
        self._place = place

    def measure(self) -> np.ndarray:
        """Measure the distance vector."""
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        return self._outside(T_wf.translation - self._place)

    def residual(self) -> tuple[float, float, bool]:
        """Give the distance last measured [m], no angle, and whether it meets the target."""
        return self._length, 0.0, self._length <= self.tolerance

    def jacobian(self) -> np.ndarray:
        """Give the Jacobian of the distance vector."""
        jacobian = pin.getFrameJacobian(
            self._model, self._data, self.frame, pin.LOCAL_WORLD_ALIGNED
        )
        return self._of_outside(jacobian[:3])


class RotationRows(ScaledRows):
    """From axes to those of a frame, ``log3`` in both."""

    def __init__(
        self, arm: RobotModel, frame: int, axes: np.ndarray, tolerance: float, scale: float = 1.0
    ) -> None:
        """Look at a frame that shall be turned some way."""  # (3, 3)
        super().__init__(arm, frame, tolerance, scale)
        self._axes = axes

    def measure(self) -> np.ndarray:
        """Measure the rotation vector."""
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        self._R_df = self._axes.T @ T_wf.rotation
        return self._outside(pin.log3(self._R_df))

    def residual(self) -> tuple[float, float, bool]:
        """Give no distance, the angle last measured [rad], and whether it meets the target."""
        return 0.0, self._length, self._length <= self.tolerance

    def jacobian(self) -> np.ndarray:
        """Give the Jacobian of the rotation vector."""
        jacobian = pin.getFrameJacobian(self._model, self._data, self.frame, pin.LOCAL)
        return self._of_outside(pin.Jlog3(self._R_df) @ jacobian[3:])


class PoseRows(Rows):
    """From a pose to a frame, ``log6`` in the pose; for tolerances without room to move in."""

    def __init__(
        self, arm: RobotModel, frame: int, pose: pin.SE3, tolerances: tuple[float, float]
    ) -> None:
        """Look at a frame that shall be at a pose.

        Args:
            arm: The arm; its data are written to.
            frame: The frame's index.
            pose: Where it shall be in the world.
            tolerances: Of position [m] and rotation [rad].
        """
        super().__init__(arm, frame, max(tolerances))
        self.aim(pose, tolerances)

    def aim(self, pose: pin.SE3, tolerances: tuple[float, float]) -> None:
        """Ask for another pose, within tolerances of position [m] and rotation [rad]."""
        self.pose, self.tolerances = pose, tolerances
        # The linear part of the logarithm is longer than the distance by less than half of pi.
        linear, angular = 0.5 * np.pi * tolerances[0], tolerances[1]
        self.near = _ROUND * (linear * linear + angular * angular)

    def measure(self) -> np.ndarray:
        """Measure the logarithm."""
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        self._T_df = T_df = self.pose.actInv(T_wf)
        self._error: np.ndarray = pin.log6(T_df).np
        return self._error

    def residual(self) -> tuple[float, float, bool]:
        """Give the distance [m] and the angle [rad] last measured, and whether both meet it."""
        x, y, z = self._T_df.translation.tolist()
        a, b, c = self._error[3:].tolist()
        position, rotation = (x * x + y * y + z * z) ** 0.5, (a * a + b * b + c * c) ** 0.5
        most, widest = self.tolerances
        return position, rotation, position <= most and rotation <= widest

    def jacobian(self) -> np.ndarray:
        """Give the Jacobian of the logarithm where it is small: it is the frame's own.

        Descents need as many steps with it as with the exact one.
        """
        return pin.getFrameJacobian(self._model, self._data, self.frame, pin.LOCAL)
