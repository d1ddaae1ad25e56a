"""PD control with gravity compensation."""

from collections.abc import Sequence

import numpy as np

from bt_manip.robots import Robot

from .controller import Controller
from .pd_law import default_gains, gain_array, pd_torque


class GravityCompensatedPD(Controller):
    """PD control of each joint, with gravity compensation.

    ``tau = Kp e + Kd de/dt + g(q)``: without inertia, friction and integral terms. It lags behind
    fast references and has a steady-state error from friction. Most arms have such a controller; it
    is the baseline for computed torque.
    """

    kind = "gravity_compensated_pd"
    saturates = True

    def _build(
        self,
        robot: Robot,
        kp: float | Sequence[float] | None = None,
        kd: float | Sequence[float] | None = None,
    ) -> None:
        """Set the gains.

        Args:
            robot: The robot to control.
            kp: Position gains [N m/rad]; default: 15 times the effort limit, less for light joints.
            kd: Velocity gains [N m s/rad]; default: 0.6 times the effort limit, less for light
                joints.

        Raises:
            ControlError: If a gain is negative, or their number is not that of the joints.
        """
        super()._build(robot)
        n = robot.limits.effort.size
        self._given = [
            None if gain is None else gain_array(name, gain, n)
            for name, gain in (("kp", kp), ("kd", kd))
        ]
        self._gains: list[np.ndarray] = []

    def _on_model_change(self) -> None:
        if not self._gains:
            default = default_gains(self.bare_model)  # without payload
            pairs = zip(self._given, default, strict=True)
            self._gains = [own if given is None else given for given, own in pairs]

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the PD torques plus gravity [N m]."""  # (nv,)
        model = self.model  # sets the gains
        kp, kd = self._gains
        return pd_torque(model, kp, kd, q, v, q_ref, v_ref)
