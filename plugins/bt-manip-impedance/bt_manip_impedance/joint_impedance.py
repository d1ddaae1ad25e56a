"""A controller under which every joint is a damped spring."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.control import Controller
from bt_manip.robots import Robot
from bt_manip_impedance.gains import ratio, stiffnesses

FRICTION_VELOCITY = 0.01
"""Reference speed at which dry friction is compensated by 76 %, the tanh of 1 [rad/s]."""


class JointImpedance(Controller):
    """``tau = K e + D de/dt + M a_ref + bias + friction``: each joint a damped spring.

    The damping follows the inertia that a joint feels at each configuration, ``D = 2 zeta
    sqrt(K M_jj)``, so that the arm is damped alike stretched out and folded. Without an integral,
    whatever holds the arm off its reference is pushed with ``K e`` and never more. Friction is
    fed forward by where the reference moves, or soft springs would drag far behind it.
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
            stiffness: Of each joint or of all [N m/rad]; default: 7 times the effort limit, with
                which a joint has to be held 140 mrad off before it pushes with all it has.
            damping_ratio: 1 comes back without swinging over [-].

        Raises:
            ControlError: When a number is negative or not finite, or there are too many or few.
        """
        super()._build(robot)
        effort = robot.limits.effort
        given = 7.0 * effort if stiffness is None else stiffness
        self.stiffness = stiffnesses("stiffness", given, effort.size)  # (nv,) [N m/rad]
        self.damping_ratio = ratio("damping_ratio", damping_ratio)

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Give the efforts of the springs, the dampers and the feed-forward [N m]."""  # (nv,)
        model = self.model
        spring = self.stiffness * (q_ref - q) + self.damping(q) * (v_ref - v)
        friction = model.damping * v_ref + model.friction * np.tanh(v_ref / FRICTION_VELOCITY)
        return spring + pin.rnea(model.model, model.data, q, v, a_ref) + friction

    def damping(self, q: np.ndarray) -> np.ndarray:
        """Give the damping of each joint at a configuration [N m s/rad]."""  # (nv,)
        model = self.model
        inertia = np.diagonal(pin.crba(model.model, model.data, q))
        return 2.0 * self.damping_ratio * np.sqrt(self.stiffness * inertia)
