"""Motions in contact under a compliant controller."""

import math
from typing import ClassVar

import numpy as np

from bt_manip.behaviours import MotionBehaviour
from bt_manip.bt import Input, Status
from bt_manip.grasping import holding_force


class CompliantMotion(MotionBehaviour):
    """A motion of a held object in contact, under a compliant controller, with a limited force.

    In any case, the arm returns to its own controller once it is at rest.
    """

    memory: ClassVar[tuple[str, ...]] = (*MotionBehaviour.memory, "_compliant", "_tare", "_limit")

    controller = Input(str, default="cartesian_impedance", doc="Registered compliant controller.")

    _compliant = False  # whether it has switched to its controller
    _limit = math.inf  # [N] force at which it gives up
    _tare: tuple[float, ...] = ()  # [N] force at the wrist before contact, in the tool's axes

    def become_compliant(self, limit: float) -> None:
        """Switch to the compliant controller.

        Args:
            limit: Force at which it gives up [N].
        """
        self._limit = limit
        self._tare = tuple(self.arm.robot.wrist_wrench().force.tolist())
        self.controllers.switch(self.controller)
        self._compliant = True

    @property
    def force(self) -> float:
        """Force at the wrist since the switch [N]."""
        return float(np.linalg.norm(self.arm.robot.wrist_wrench().force - np.array(self._tare)))

    @property
    def grip_force(self) -> float:
        """Largest force transmitted by the grip [N]."""
        name: str = self.read_port("object")
        return holding_force(self.cell, self.gripper, name, float(np.mean(self.gripper.forces)))

    def has_stopped(self) -> bool:
        """Return whether the arm has been at rest for `SETTLING`; call it at each tick at rest."""
        self._ended = self.cell.time if self._ended is None else self._ended
        return self.cell.time - self._ended > self.SETTLING

    def terminate(self, new_status: Status) -> None:
        """Stop, and return to the arm's own controller."""
        if self._compliant:
            self._compliant = False
            if self.arm.busy:
                self.arm.stop()
            self.controllers.return_to_default()
        super().terminate(new_status)
