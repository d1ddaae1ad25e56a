"""Residuals of frames from their targets and their Jacobians, single and stacked."""

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

WIDE = 1e-3  # [m] or [rad] tolerance from which on the residual has a dead zone
DEAD_ZONE = 0.9  # dead zone of a wide tolerance, relative to it
_ABOVE_ROUNDING = 1.0 + 1e-9


class FrameResidual:
    """Residual of one frame, a function of the configuration.

    Attributes:
        frame: Index of the frame.
        squared_bound: Squared norm of the residual above which the target is not reached.
        accepted_bound: Squared norm of the residual above which the target is not met.
    """

    squared_bound: float
    accepted_bound: float

    def __init__(self, arm: RobotModel, frame: int) -> None:
        self._model, self._data, self.frame = arm.model, arm.data, frame

    def evaluate(self) -> np.ndarray:
        """Return the residual, after `pin.computeJointJacobians`."""  # (m,)
        raise NotImplementedError

    def jacobian(self) -> np.ndarray:
        """Return J of ``d residual = J dq`` at the last evaluation."""  # (m, nv)
        raise NotImplementedError

    @property
    def reached(self) -> bool:
        """Whether the error is as small as desired, at the last evaluation."""
        raise NotImplementedError

    def errors(self) -> tuple[float, float, bool]:
        """Return distance [m], angle [rad] and whether the target is met, at the last evaluation.

        The distance of a rotation and the angle of a position are 0.
        """
        raise NotImplementedError


class VectorResidual(FrameResidual):
    """Residual of three components with a weight, or with a dead zone within a wide tolerance.

    Args:
        arm: The arm; its data are written to.
        frame: Index of the frame.
        target: Position [m] or rotation matrix in the world.  # (3,) or (3, 3)
        tolerance: Desired error [m] or [rad].
        scale: Square root of the weight; 1 for a constraint.
        accepted: Largest error that meets the target, at least `tolerance`.
    """

    def __init__(
        self,
        arm: RobotModel,
        frame: int,
        target: np.ndarray,
        tolerance: float,
        scale: float = 1.0,
        accepted: float = 0.0,
    ) -> None:
        super().__init__(arm, frame)
        self._target, self._tolerance, self._scale = target, tolerance, scale
        self._dead_zone = DEAD_ZONE * tolerance if WIDE <= tolerance < np.inf else 0.0
        self._accepted = max(tolerance, accepted)
        self.squared_bound = (tolerance - self._dead_zone) ** 2 * _ABOVE_ROUNDING
        self.accepted_bound = (self._accepted - self._dead_zone) ** 2 * _ABOVE_ROUNDING

    @property
    def reached(self) -> bool:
        """Whether the error is as small as desired, at the last evaluation."""
        return self._length <= self._tolerance

    def _scaled(self, error: np.ndarray) -> np.ndarray:
        """Return the residual for an error: weighted, or the part outside the dead zone."""
        self._error = error
        self._length = length = float(error.dot(error)) ** 0.5
        if self._dead_zone:
            return error * max(0.0, 1.0 - self._dead_zone / max(length, self._dead_zone))
        return self._scale * error

    def _scaled_jacobian(self, jacobian: np.ndarray) -> np.ndarray:
        """Return the Jacobian of the residual, given the Jacobian of the error."""
        if not self._dead_zone:
            return self._scale * jacobian
        if self._length <= self._dead_zone:
            return np.zeros_like(jacobian)
        share, along = self._dead_zone / self._length, self._error / self._length
        return (1.0 - share) * jacobian + share * np.outer(along, along @ jacobian)


class PositionResidual(VectorResidual):
    """Vector from a position to the origin or another point of a frame, in the world's axes."""

    pivot: np.ndarray | None = None
    """The point in the frame [m]; None for the origin."""  # (3,)

    def evaluate(self) -> np.ndarray:
        """Return the residual, after `pin.computeJointJacobians`."""  # (3,)
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        if self.pivot is None:
            return self._scaled(T_wf.translation - self._target)
        self._lever = T_wf.rotation.dot(self.pivot)
        return self._scaled(T_wf.translation + self._lever - self._target)

    def errors(self) -> tuple[float, float, bool]:
        """Return the distance [m], 0, and whether the target is met, at the last evaluation."""
        return self._length, 0.0, self._length <= self._accepted

    def jacobian(self) -> np.ndarray:
        """Return the Jacobian at the last evaluation of the residual."""  # (3, nv)
        jacobian = pin.getFrameJacobian(
            self._model, self._data, self.frame, pin.LOCAL_WORLD_ALIGNED
        )
        if self.pivot is None:
            return self._scaled_jacobian(jacobian[:3])
        return self._scaled_jacobian(jacobian[:3] - pin.skew(self._lever).dot(jacobian[3:]))


class RotationResidual(VectorResidual):
    """Rotation vector ``log3`` from the target axes to the axes of a frame, equal in both."""

    def evaluate(self) -> np.ndarray:
        """Return the residual, after `pin.computeJointJacobians`."""  # (3,)
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        self._R_tf = self._target.T @ T_wf.rotation
        return self._scaled(pin.log3(self._R_tf))

    def errors(self) -> tuple[float, float, bool]:
        """Return 0, the angle [rad] and whether the target is met, at the last evaluation."""
        return 0.0, self._length, self._length <= self._accepted

    def jacobian(self) -> np.ndarray:
        """Return the Jacobian at the last evaluation of the residual."""  # (3, nv)
        jacobian = pin.getFrameJacobian(self._model, self._data, self.frame, pin.LOCAL)
        return self._scaled_jacobian(pin.Jlog3(self._R_tf) @ jacobian[3:])


class AxisResidual(VectorResidual):
    """Vector from a direction to an axis of a frame, with the length of the chord between them.

    Args:
        arm: The arm; its data are written to.
        frame: Index of the frame.
        direction: Direction in the world; unit.  # (3,)
        axis: Axis in the frame that has this direction at the target; unit.  # (3,)
        tolerance: Desired angle [rad].
        scale: Square root of the weight; 1 for a constraint.
        accepted: Largest angle that meets the target, at least `tolerance`.
    """

    def __init__(
        self,
        arm: RobotModel,
        frame: int,
        direction: np.ndarray,
        axis: np.ndarray,
        tolerance: float,
        scale: float = 1.0,
        accepted: float = 0.0,
    ) -> None:
        super().__init__(arm, frame, direction, chord(tolerance), scale, chord(accepted))
        self._axis = axis

    def evaluate(self) -> np.ndarray:
        """Return the residual, after `pin.computeJointJacobians`."""  # (3,)
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        self._current = T_wf.rotation.dot(self._axis)
        return self._scaled(self._current - self._target)

    def errors(self) -> tuple[float, float, bool]:
        """Return 0, the angle [rad] and whether the target is met, at the last evaluation."""
        angle = 2.0 * math.asin(min(0.5 * self._length, 1.0))
        return 0.0, angle, self._length <= self._accepted

    def jacobian(self) -> np.ndarray:
        """Return the Jacobian at the last evaluation of the residual."""  # (3, nv)
        jacobian = pin.getFrameJacobian(
            self._model, self._data, self.frame, pin.LOCAL_WORLD_ALIGNED
        )
        return self._scaled_jacobian(pin.skew(-self._current).dot(jacobian[3:]))


def chord(angle: float) -> float:
    """Return the distance of two unit vectors at an angle [rad]; infinite for an infinite angle."""
    return 2.0 * math.sin(0.5 * min(angle, math.pi)) if angle < math.inf else angle


class PoseResidual(FrameResidual):
    """Logarithm ``log6`` of a frame's pose in the target pose, for narrow tolerances."""

    def __init__(
        self,
        arm: RobotModel,
        frame: int,
        pose: pin.SE3,
        tolerances: tuple[float, float],
        accepted: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        super().__init__(arm, frame)
        self.set_target(pose, tolerances, accepted)

    def set_target(
        self,
        pose: pin.SE3,
        tolerances: tuple[float, float],
        accepted: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Set another target pose.

        Args:
            pose: The pose in the world.
            tolerances: Desired errors [m] and [rad].
            accepted: Largest errors that meet the target, if larger than `tolerances`.
        """
        self.pose, self.tolerances = pose, tolerances
        self.accepted = max(tolerances[0], accepted[0]), max(tolerances[1], accepted[1])
        self.squared_bound, self.accepted_bound = _bound(tolerances), _bound(self.accepted)

    def evaluate(self) -> np.ndarray:
        """Return the residual, after `pin.computeJointJacobians`."""  # (6,)
        T_wf = pin.updateFramePlacement(self._model, self._data, self.frame)
        self._T_tf = T_tf = self.pose.actInv(T_wf)
        self._residual: np.ndarray = pin.log6(T_tf).np
        return self._residual

    def errors(self) -> tuple[float, float, bool]:
        """Return distance [m], angle [rad] and whether the target is met, at last evaluation."""
        x, y, z = self._T_tf.translation.tolist()
        a, b, c = self._residual[3:].tolist()
        position, rotation = (x * x + y * y + z * z) ** 0.5, (a * a + b * b + c * c) ** 0.5
        return position, rotation, position <= self.accepted[0] and rotation <= self.accepted[1]

    @property
    def reached(self) -> bool:
        """Whether both errors are as small as desired, at the last evaluation."""
        position, rotation, _ = self.errors()
        return position <= self.tolerances[0] and rotation <= self.tolerances[1]

    def jacobian(self) -> np.ndarray:
        """Return the frame's own Jacobian, that of a small logarithm.

        Levenberg-Marquardt needs as many steps with it as with the exact Jacobian.
        """  # (6, nv)
        return pin.getFrameJacobian(self._model, self._data, self.frame, pin.LOCAL)


def _bound(tolerances: tuple[float, float]) -> float:
    # The linear part of the logarithm is at most pi / 2 times the distance.
    linear, angular = 0.5 * np.pi * tolerances[0], tolerances[1]
    return _ABOVE_ROUNDING * (linear * linear + angular * angular)


class StackedResidual:
    """Residuals of several targets as one vector.

    Args:
        arm: The arm; its data are written to.
        moving: Which joints may move; by default all.  # (nv,)

    Attributes:
        parts: The residuals of the targets.
        q: The configuration of the last evaluation.  # (nq,)
    """

    def __init__(
        self, arm: RobotModel, parts: Sequence[FrameResidual], moving: np.ndarray | None = None
    ) -> None:
        self._model, self._data = arm.model, arm.data
        self.parts = tuple(parts)
        self._only = self.parts[0] if len(self.parts) == 1 else None
        self._moving = moving
        self.q: np.ndarray | None = None

    def evaluate(self, q: np.ndarray) -> np.ndarray:
        """Return the stacked residual at a configuration."""  # (m,)
        pin.computeJointJacobians(self._model, self._data, q)
        self.q = q
        if self._only is not None:
            return self._only.evaluate()
        return np.concatenate([part.evaluate() for part in self.parts] or [np.zeros(0)])

    @property
    def squared_bound(self) -> float:
        """Squared norm of the residual above which at least one target is not reached."""
        return sum([part.squared_bound for part in self.parts])

    @property
    def accepted_bound(self) -> float:
        """Squared norm of the residual above which at least one target is not met."""
        return sum([part.accepted_bound for part in self.parts])

    @property
    def reached(self) -> bool:
        """Whether all errors are as small as desired, at the last evaluation."""
        return all([part.reached for part in self.parts])

    @property
    def met(self) -> bool:
        """Whether all targets are met, at the last evaluation."""
        return all([part.errors()[2] for part in self.parts])

    def jacobian(self) -> np.ndarray:
        """Return J of ``d residual = J dq`` at the last evaluation."""  # (m, nv)
        if self._only is not None:
            jacobian = self._only.jacobian()
        else:
            empty = np.zeros((0, self._model.nv))
            jacobian = np.vstack([part.jacobian() for part in self.parts] or [empty])
        return jacobian if self._moving is None else jacobian * self._moving
