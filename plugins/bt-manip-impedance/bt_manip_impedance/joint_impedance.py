"""Joint impedance control."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.control import Controller, gain_array
from bt_manip.robots import Robot


class JointImpedance(Controller):
    """Joint impedance control: a damped spring between each joint and its reference.

    ``tau = K e + D de/dt + M a_ref + bias + friction``

    The damping ``D = 2 zeta sqrt(K M_jj)`` depends on the inertia of each joint, so that the
    damping ratio is the same in all configurations. There is no integral term: at an error e in
    contact, the torque is ``K e``. Friction is compensated using the reference velocity, since soft
    springs would lag far behind otherwise.
    """

    kind = "joint_impedance"
    saturates = True

    def _build(
        self,
        robot: Robot,
        stiffness: float | Sequence[float] | None = None,
        damping_ratio: float = 1.0,
    ) -> None:
        """Set stiffness and damping.

        Args:
            robot: The robot to control.
            stiffness: One number, or one per joint [N m/rad]; default: 7 times the effort limit, so
                that an error of 140 mrad saturates a joint.
            damping_ratio: Damping ratio; 1 is critical damping [-].

        Raises:
            ControlError: If a number is negative or not finite, or their count is wrong.
        """
        super()._build(robot)
        effort = robot.limits.effort
        given = 7.0 * effort if stiffness is None else stiffness
        self.stiffness = gain_array("stiffness", given, effort.size)  # (nv,) [N m/rad]
        self.damping_ratio = gain_array("damping_ratio", damping_ratio, 1, "values")[0]

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the torques of springs, dampers and feedforward [N m]."""  # (nv,)
        model = self.model
        spring = self.stiffness * (q_ref - q) + self.damping(q) * (v_ref - v)
        return spring + pin.rnea(model.model, model.data, q, v, a_ref) + model.losses(v_ref)

    def damping(self, q: np.ndarray) -> np.ndarray:
        """Return the damping of each joint at a configuration [N m s/rad]."""  # (nv,)
        model = self.model
        inertia = np.diagonal(pin.crba(model.model, model.data, q))
        return 2.0 * self.damping_ratio * np.sqrt(self.stiffness * inertia)
