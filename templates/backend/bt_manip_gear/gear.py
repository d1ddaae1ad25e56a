"""The arm and its gripper, on one connection."""

import time
from dataclasses import dataclass

import numpy as np
from bt_manip.robots import ArmDevice, DeviceAddress, DeviceState, GripperDevice, GripperState

HOME = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])  # [rad]
OPEN_WIDTH = 0.08  # [m]


@dataclass(frozen=True)
class Address(DeviceAddress):
    """``HOST`` or ``HOST?collision_force=40``: what is set on the arm."""

    collision_force: float = 20.0  # [N]


class Gear(ArmDevice):
    """An arm that follows at once; put the calls of the vendor's driver in its place."""

    def __init__(self, address):
        """Parse the address; `connect` connects."""
        self._address = Address.parse(address)
        self.period = 2e-3  # [s] between two references
        # None where `Backend.gripper` names a device of its own:
        self.gripper = GearGripper()
        self._q, self._v = HOME.copy(), np.zeros(7)

    @property
    def properties(self):
        """Describe the connection in reports."""
        return {"controller": "simulated"}

    def connect(self):
        """Connect; raise a DeviceError that says what to do where that fails."""

    def close(self):
        """Disconnect."""

    def read(self):
        """Return the present state, once a cycle."""
        self.wait_for_cycle()  # a driver that waits for the robot makes this superfluous
        # Torques that the arm does not measure are None, which is not the same as zeros.
        return DeviceState(self._q, self._v, tau=None, tau_external=None, q_held=self._q)

    def write(self, q):
        """Command the reference of this cycle [rad]."""
        self._v, self._q = (q - self._q) / self.period, q.copy()

    def finish(self):
        """End the motion."""
        self._v = np.zeros(7)

    def recover(self):
        """Clear errors of the arm."""


class GearGripper(GripperDevice):
    """A gripper that closes on nothing; another thread than that of the arm calls it."""

    def __init__(self):
        """Begin open."""
        self._width = OPEN_WIDTH

    def connect(self):
        """Do nothing: it is connected with the arm."""

    def close(self):
        """Do nothing: it is disconnected with the arm."""

    def read(self):
        """Return the present state."""
        return GripperState(self._width, is_grasped=False)

    def grasp(self, width, speed, force):
        """Close; return whether something is gripped."""
        time.sleep(self._width / speed)
        self._width = 0.0
        return False

    def move(self, width, speed):
        """Move to a width [m]; return whether it got there."""
        if width > OPEN_WIDTH:
            return False
        time.sleep(abs(width - self._width) / speed)
        self._width = width
        return True
