"""The controller."""

import numpy as np
from bt_manip.control import Controller


class Gear(Controller):
    """``tau = M (a_ref + kp e + kd de/dt) + bias + friction``: computed torque in a few lines."""

    kind = "gear"
    saturates = True  # clip torques beyond the effort limits; otherwise they are a fault

    def _build(self, robot, kp=900.0, kd=60.0):
        super()._build(robot)
        self.kp, self.kd = kp, kd  # [1/s2], [1/s]: both poles at -30 rad/s

    def compute(self, q, v, q_ref, v_ref, a_ref):
        """Return the joint torques of one step of 1 ms [N m]."""  # (nv,)
        model = self.model  # includes the payload
        a = a_ref + self.kp * (q_ref - q) + self.kd * (v_ref - v)
        # Dry friction from the reference velocity; the measured one would cause chatter at rest.
        friction = model.damping * v + model.friction * np.tanh(v_ref / 0.01)
        return model.rnea(q, v, a) + friction
