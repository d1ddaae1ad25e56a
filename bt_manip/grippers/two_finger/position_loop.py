"""Position control of two fingers."""

from .stroke import Motion
from .transmission import Fingers

# Poles of a finger's position loop [rad/s], well below a tenth of the sampling rate (628 rad/s).
_POLE = 150.0
_PUSH = 20.0  # [N] maximum force of a finger under position control, or
_PUSH_SHARE = 1.5  # of the force that accelerates it, if larger


class FingerLoop:
    """A PD position loop with two equal poles and acceleration feedforward for each finger.

    Attributes:
        stiffness: Position gain of a finger [N/m].
        damping: Velocity gain of a finger, including its viscous friction [N s/m].
    """

    def __init__(self, mass: float, loss: float, acceleration: float) -> None:
        """Tune the loop to a gripper.

        Args:
            mass: Effective mass of one finger [kg].
            loss: Viscous friction of one finger [N s/m].
            acceleration: Maximum acceleration of a finger [m/s2].
        """
        self._push = max(_PUSH, _PUSH_SHARE * mass * acceleration)
        self._mass = mass
        self.stiffness = mass * _POLE * _POLE
        self.damping = 2.0 * mass * _POLE
        self._added = self.damping - loss  # viscous friction provides the rest

    def forces(self, motion: Motion, fingers: Fingers) -> tuple[float, float]:
        """Return the forces that make the fingers follow a motion, positive to open [N].

        Args:
            motion: Desired motion of each finger.
            fingers: Measured positions and velocities of the fingers.
        """
        s, v, a = motion
        s1, s2, v1, v2 = fingers
        k, added = self.stiffness, self._added
        ahead = self._mass * a + self.damping * v + k * s
        f1 = ahead - k * s1 - added * v1
        f2 = ahead - k * s2 - added * v2
        push = self._push
        if -push < f1 < push and -push < f2 < push:
            return f1, f2
        return min(max(f1, -push), push), min(max(f2, -push), push)
