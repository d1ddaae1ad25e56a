"""Errors of frames from their targets, with their Jacobians.

Each kind has `measure`, to be called after `pin.computeJointJacobians`, and `jacobian`, the matrix
J of ``d error = -J dq``.
"""

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

WIDE = 1e-3  # [m] and [rad] from which a tolerance is room to move in
AIM = 0.9  # of a wide tolerance, that an error outside is brought back to


class Rows:
    """What all kinds have in common.

    Attributes:
        error: The error last measured.  # (size,)
        position: Its distance [m]; 0 where the kind has none.
        rotation: Its angle [rad]; 0 where the kind has none.
        met: Whether it is within the tolerance.
        frame: Index of the frame.
    """

    size = 3

    def __init__(self, arm: RobotModel, frame: int, tolerance: float, scale: float) -> None:
        """Look at a frame.

        Args:
            arm: The arm; its data are written to.
            frame: The frame's index.
            tolerance: Largest error that meets the target.
            scale: Root of the weight; 1 for a constraint.
        """
        self._model, self._data, self.frame = arm.model, arm.data, frame
        self.tolerance, self._scale = tolerance, scale
        self._room = AIM * tolerance if WIDE <= tolerance < np.inf else 0.0
        self.error = np.zeros(self.size)
        self.position = self.rotation = 0.0
        self.met = False

    def measure(self) -> bool:
        """Measure the error; tell whether the target is met."""
        raise NotImplementedError

    def jacobian(self) -> np.ndarray:
        """Give the Jacobian where the error was measured last."""  # (size, nv)
        raise NotImplementedError

    def _outside(self, error: np.ndarray, length: float) -> np.ndarray:
        """Leave of an error what is outside the room that a wide tolerance gives."""
        self._whole, self._length = error, length
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


class PositionRows(Rows):
    """From the origin of a frame to a place, in the world's axes."""

    def __init__(
        self, arm: RobotModel, frame: int, place: np.ndarray, tolerance: float, scale: float = 1.0
    ) -> None:
        """Look at a frame that shall be at a place [m]."""  # (3,)
        super().__init__(arm, frame, tolerance, scale)
        self._place = place

    def measure(self) -> bool:
        """Measure the distance."""
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        error = self._place - T_wf.translation
        self.position = float(error.dot(error)) ** 0.5
        self.error = self._outside(error, self.position)
        self.met = self.position <= self.tolerance
        return self.met

    def jacobian(self) -> np.ndarray:
        """Give the Jacobian of the distance vector."""
        jacobian = pin.getFrameJacobian(
            self._model, self._data, self.frame, pin.LOCAL_WORLD_ALIGNED
        )
        return self._of_outside(jacobian[:3])


class RotationRows(Rows):
    """From the axes of a frame to others, ``log3`` in the frame."""

    def __init__(
        self, arm: RobotModel, frame: int, axes: np.ndarray, tolerance: float, scale: float = 1.0
    ) -> None:
        """Look at a frame that shall be turned some way."""  # (3, 3)
        super().__init__(arm, frame, tolerance, scale)
        self._axes = axes

    def measure(self) -> bool:
        """Measure the angle."""
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        self._R_fd = T_wf.rotation.T @ self._axes
        error = pin.log3(self._R_fd)
        self.rotation = float(error.dot(error)) ** 0.5
        self.error = self._outside(error, self.rotation)
        self.met = self.rotation <= self.tolerance
        return self.met

    def jacobian(self) -> np.ndarray:
        """Give the Jacobian of the rotation vector."""
        jacobian = pin.getFrameJacobian(self._model, self._data, self.frame, pin.LOCAL)
        return self._of_outside(pin.Jlog3(self._R_fd.T) @ jacobian[3:])


class PoseRows(Rows):
    """From a frame to a pose, ``log6`` in the frame; for tolerances without room to move in."""

    size = 6

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
        super().__init__(arm, frame, max(tolerances), 1.0)
        self.pose, self.tolerances = pose, tolerances

    def measure(self) -> bool:
        """Measure distance and angle."""
        T_fd = pin.updateFramePlacement(self._model, self._data, self.frame).actInv(self.pose)
        self._T_fd = T_fd
        self.error = error = pin.log6(T_fd).np
        x, y, z = T_fd.translation.tolist()
        self.position = (x * x + y * y + z * z) ** 0.5
        angular = error[3:]
        self.rotation = float(angular.dot(angular)) ** 0.5
        most, widest = self.tolerances
        self.met = self.position <= most and self.rotation <= widest
        return self.met

    def jacobian(self) -> np.ndarray:
        """Give the Jacobian of the logarithm."""
        jacobian = pin.getFrameJacobian(self._model, self._data, self.frame, pin.LOCAL)
        return pin.Jlog6(self._T_fd.inverse()).dot(jacobian)
