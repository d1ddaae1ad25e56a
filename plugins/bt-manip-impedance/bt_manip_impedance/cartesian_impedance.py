"""Cartesian impedance control."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.control import Controller, gain_array
from bt_manip.robots import Robot

REGULARISATION = 1e-3
"""Regularization of the tool's mobility at singularities, added to its diagonal
[1/kg and 1/(kg m2)]."""


class CartesianImpedance(Controller):
    """Cartesian impedance control with a null-space posture.

    ``tau = J' (K e + D de/dt) + N' tau_0 + M a_ref + bias + friction``

    Damped springs along and about the world's axes pull the tool to its reference pose: at a
    displacement d the contact force is ``K d``. Weak joint springs keep the posture; their torques
    ``tau_0`` are projected into the null space, so that they do not accelerate the tool (O. Khatib,
    "A unified approach for motion and force control of robot manipulators", IEEE J. of Robotics and
    Automation 3, 1987).

    The damping of each axis is derived from the tool's effective mass along it with all other axes
    free, ``1 / (J M^-1 J')_ii``, which is finite at singularities.
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
            stiffness: Stiffness along the world's axes, one number or three [N/m].
            rotational_stiffness: Stiffness about the world's axes, one number or three [N m/rad].
            posture_stiffness: Stiffness of the joints in the null space [N m/rad].
            damping_ratio: Damping ratio; 1 is critical damping [-].

        Raises:
            ControlError: If a number is negative or not finite, or their count is wrong.
        """
        super()._build(robot)
        linear = gain_array("stiffness", stiffness, 3, "axes")
        angular = gain_array("rotational_stiffness", rotational_stiffness, 3, "axes")
        self.stiffness = np.concatenate((linear, angular))  # (6,)
        self.posture_stiffness = gain_array("posture_stiffness", posture_stiffness, 1, "values")[0]
        self.damping_ratio = gain_array("damping_ratio", damping_ratio, 1, "values")[0]

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the torques of springs, dampers and feedforward [N m]."""  # (nv,)
        model = self.model
        feedforward = pin.rnea(model.model, model.data, q, v, a_ref) + model.losses(v_ref)
        error = self.error(q, q_ref)
        inertias = np.diagonal(pin.crba(model.model, model.data, q))
        J = model.jacobian(q)
        J_Minv = J @ pin.computeMinverse(model.model, model.data, q)  # (6, nv)
        mobility = J_Minv @ J.T  # (6, 6)
        damping = 2.0 * self.damping_ratio * np.sqrt(self.stiffness / np.diagonal(mobility))
        v_error = v_ref - v
        wrench = self.stiffness * error + damping * (J @ v_error)
        posture = self.posture_stiffness * (q_ref - q) + v_error * (
            2.0 * self.damping_ratio * np.sqrt(self.posture_stiffness * inertias)
        )
        mobility.flat[::7] += REGULARISATION  # the diagonal
        # Cancel the tool's acceleration due to the posture torques.
        wrench -= np.linalg.solve(mobility, J_Minv @ posture)
        return feedforward + J.T @ wrench + posture

    def error(self, q: np.ndarray, q_ref: np.ndarray) -> np.ndarray:
        """Return the pose error of the tool along and about the world's axes."""
        T_wt, T_ref = self.model.pose(q), self.model.pose(q_ref)
        R = T_wt.rotation
        turn = R @ pin.log3(R.T @ T_ref.rotation)
        return np.concatenate((T_ref.translation - T_wt.translation, turn))  # (6,) [m, rad]
