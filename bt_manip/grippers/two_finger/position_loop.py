"""How two fingers are kept on their stroke."""

from .stroke import Motion
from .transmission import Fingers

# Poles of a finger's position loop [rad/s]; a tenth of the sampling rate is 628.
_POLE = 150.0
_PUSH = 20.0  # [N] most that a finger pushes with while it follows a position


class FingerLoop:
    """A position loop with two equal poles for each finger, and what the motion needs ahead of it.

    Attributes:
        stiffness: Force for each metre that a finger is off [N/m].
        damping: Force for each m/s that a finger is off [N s/m].
    """

    def __init__(self, mass: float, loss: float) -> None:
        """Tune the loop to a gripper.

        Args:
            mass: What the force of one finger has to accelerate [kg].
            loss: Viscous friction of one finger [N s/m].
        """
        self._mass = mass
        self.stiffness = mass * _POLE * _POLE
        self.damping = 2.0 * mass * _POLE
        self._added = self.damping - loss  # friction does its share of the damping

    def forces(self, motion: Motion, fingers: Fingers) -> tuple[float, float]:
        """Give the forces that keep the fingers on a motion, opening ones being positive [N].

        Args:
            motion: Where each finger should be now.
            fingers: Where they are.
        """
        s, v, a = motion
        s1, s2, v1, v2 = fingers
        k, added = self.stiffness, self._added
        ahead = self._mass * a + self.damping * v + k * s
        f1 = ahead - k * s1 - added * v1
        f2 = ahead - k * s2 - added * v2
        if -_PUSH < f1 < _PUSH and -_PUSH < f2 < _PUSH:
            return f1, f2
        return min(max(f1, -_PUSH), _PUSH), min(max(f2, -_PUSH), _PUSH)
