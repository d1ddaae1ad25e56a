"""A controller under which the tool is held by damped springs."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.control import Controller
from bt_manip.robots import Robot
from bt_manip_impedance.gains import ratio, stiffnesses
from bt_manip_impedance.joint_impedance import FRICTION_VELOCITY

REGULARISATION = 1e-3
"""Added to the tool's mobility [1/kg and 1/(kg m2)], which loses its rank at singularities."""


class CartesianImpedance(Controller):
    """``tau = J' (K e + D de/dt) + N' tau_0 + M a_ref + bias + friction``: springs at the tool.

    The tool is pulled to where it would be on the reference, by springs along and about the
    axes of the world. What pushes it away by d feels ``K d`` and never more: that is how hard it
    presses on what it meets. Joints that the tool does not need are drawn to their reference by
    weak springs, whose efforts ``tau_0`` are projected so that they do not accelerate the tool
    (O. Khatib, "A unified approach for motion and force control of robot manipulators", IEEE J.
    of Robotics and Automation 3, 1987).

    The damping of each spring follows the mass that is felt along its axis when the tool is free
    in all others, ``1 / (J M^-1 J')_ii``, which stays finite in singularities.
    """

    kind = "cartesian_impedance"
    saturates = True

    def _build(
        self,
        robot: Robot,
        stiffness: float | Sequence[float] = 1000.0,
        rotational_stiffness: float | Sequence[float] = 100.0,
        posture_stiffness: float = 20.0,
        damping_ratio: float = 1.0,
    ) -> None:
        """Set stiffness and damping.

        Args:
            robot: The robot to control.
            stiffness: Along the world's axes, or each of them [N/m].
            rotational_stiffness: About the world's axes, or each of them [N m/rad].
            posture_stiffness: Of the joints, where the tool leaves them free [N m/rad].
            damping_ratio: 1 comes back without swinging over [-].

        Raises:
            ControlError: When a number is negative or not finite, or there are too many or few.
        """
        super()._build(robot)
        linear = stiffnesses("stiffness", stiffness, 3)
        angular = stiffnesses("rotational_stiffness", rotational_stiffness, 3)
        self.stiffness = np.concatenate((linear, angular))  # (6,)
        self.posture_stiffness = stiffnesses("posture_stiffness", posture_stiffness, 1)[0]
        self.damping_ratio = ratio("damping_ratio", damping_ratio)

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Give the efforts of the springs, the dampers and the feed-forward [N m]."""  # (nv,)
        model = self.model
        friction = model.damping * v_ref + model.friction * np.tanh(v_ref / FRICTION_VELOCITY)
        feed_forward = pin.rnea(model.model, model.data, q, v, a_ref) + friction
        error = self.error(q, q_ref)
        M = _inertia(model, q)
        J = model.jacobian(q)
        J_Minv = np.linalg.solve(M, J.T).T  # (6, nv)
        mobility = J_Minv @ J.T  # (6, 6)
        damping = 2.0 * self.damping_ratio * np.sqrt(self.stiffness / np.diagonal(mobility))
        late = v_ref - v
        wrench = self.stiffness * error + damping * (J @ late)
        posture = self.posture_stiffness * (q_ref - q) + late * (
            2.0 * self.damping_ratio * np.sqrt(self.posture_stiffness * np.diagonal(M))
        )
        mobility[np.diag_indices(6)] += REGULARISATION
        # What the posture would accelerate the tool by is taken off it again.
        wrench -= np.linalg.solve(mobility, J_Minv @ posture)
        return feed_forward + J.T @ wrench + posture

    def error(self, q: np.ndarray, q_ref: np.ndarray) -> np.ndarray:
        """Give how far the tool is from where it should be: along and about the world's axes."""
        T_wt, T_ref = self.model.pose(q), self.model.pose(q_ref)
        R = T_wt.rotation
        turn = R @ pin.log3(R.T @ T_ref.rotation)
        return np.concatenate((T_ref.translation - T_wt.translation, turn))  # (6,) [m, rad]


def _inertia(model, q: np.ndarray) -> np.ndarray:
    """Give the arm's inertia matrix; Pinocchio fills the upper half alone."""
    upper = np.triu(pin.crba(model.model, model.data, q))
    return upper + np.triu(upper, 1).T
