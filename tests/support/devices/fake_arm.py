"""A plugin with an arm and a gripper that follow perfectly, for tests.

The address is the speed of its clock, and a file for all references: ``fake=4,rows.npy``. A file
``rows.npy.problem`` is a problem of the arm while it exists, ``rows.npy.pushed`` moves the arm,
``rows.npy.force`` is an external torque, and the arm writes the id of its process to
``rows.npy.moving`` when it sets off.
"""

import os
import time
from pathlib import Path

import numpy as np

from bt_manip import hookimpl
from bt_manip.robots import ArmDevice, Backend, DeviceState, GripperDevice, GripperState

LOOKING = 10
"""Cycles between two looks at the files, which take longer than the rest of a cycle."""

HOME = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])


class FakeArm(ArmDevice):
    def __init__(self, address):
        speed, _, file = address.partition(",")
        self.pause = self.period / float(speed)
        self.file = Path(file) if file else None
        self.q, self.before, self.written = HOME.copy(), HOME.copy(), []
        self.cycle, self.text, self.force = 0, "", np.zeros(7)

    def beside(self, suffix):
        return self.file.with_name(f"{self.file.name}.{suffix}") if self.file else Path("none")

    def connect(self):
        self.due = time.perf_counter()

    def close(self):
        if self.file is not None:
            part = self.file.with_suffix(".part.npy")
            np.save(part, np.array(self.written))
            part.rename(self.file)

    def read(self):
        self.due = max(self.due + self.pause, time.perf_counter() - 0.02)
        time.sleep(max(0.0, self.due - time.perf_counter()))
        self.cycle += 1
        if self.cycle % LOOKING == 0:
            self.look()
        v, self.before = (self.q - self.before) / self.period, self.q.copy()
        return DeviceState(self.q, v, np.zeros(7), self.force, self.text, bool(self.text))

    def look(self):
        """See what the files beside that of the references say."""
        if self.beside("pushed").exists():
            self.beside("pushed").unlink()
            self.q = self.q + np.array([0.0, 0.1, 0, 0, 0, 0, 0])
        self.text = self.beside("problem").read_text() if self.beside("problem").exists() else ""
        self.force = np.full(7, 30.0 if self.beside("force").exists() else 0.0)

    def start(self):
        if self.file is not None:
            self.beside("moving").write_text(str(os.getpid()))

    def write(self, q):
        self.q = q.copy()
        self.written.append(self.q)

    def recover(self):
        self.beside("problem").unlink()
        self.text = ""


class FakeGripper(GripperDevice):
    """Finds an object of 40 mm wherever it closes."""

    found = 0.05  # [m]

    def __init__(self, address):
        self.width, self.grasped = 0.08, False

    def connect(self):
        pass

    def close(self):
        pass

    def read(self):
        return GripperState(self.width, self.grasped)

    def grasp(self, width, speed, force):
        time.sleep(0.05)
        self.width, self.grasped = self.found or 0.0, bool(self.found)
        return self.grasped

    def move(self, width, speed):
        time.sleep(0.05)
        if width > 0.08:
            return False
        self.width, self.grasped = width, False
        return True


class SaggingArm(FakeArm):
    """Sags, measures no torques, has a period of 2.5 ms, and a gripper on its connection."""

    period, steady_state_error = 2.5e-3, 0.06
    sag = np.array([0.0, 0.05, 0.0, 0.0, 0.0, 0.03, 0.0])  # [rad]

    def __init__(self, address):
        super().__init__(address)
        self.gripper = FakeGripper(address)

    def read(self):
        state = super().read()
        return state._replace(q=self.q + self.sag, tau=None, tau_external=None, q_held=self.q)


@hookimpl
def register_backends(register):
    """Register the fake arm; the folder of this file is to be in the path of modules."""
    register("fake", Backend("fake_arm:FakeArm", "fake_arm:FakeGripper"))
    register("sagging", Backend("fake_arm:SaggingArm"))
