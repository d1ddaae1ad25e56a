"""A real arm in the simulated cell, at its measured joint positions."""

import numpy as np
from dm_control import mjcf

from bt_manip.robots import ArmConnection, Robot, writer

from .controller import Controller


class MeasuredArm(Controller):
    """Represents a controller of the vendor, which follows the reference on the real arm.

    After each step it writes the measured joint positions into the physics, and the pose of the
    held object in the gripper. Torques are measured by the arm.
    """

    kind = "measured_arm"

    def _build(self, robot: Robot, connection: ArmConnection) -> None:  # type: ignore[override]
        """Read the arm's state from a connection."""
        super()._build(robot)
        self._connection = connection
        self._reading = connection.latest
        self._still = np.zeros_like(self._limit)

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return zero torques: the arm is not simulated."""
        return np.zeros_like(self._limit)

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model."""
        super().after_compile(physics, random_state)
        robot, data = self.robot, physics.data.ptr
        robot.read_a = lambda: self._still
        robot.read_tau = lambda: self._reading.tau
        robot.read_tau_external = lambda: self._reading.tau_external
        self._write_q = writer(data.qpos, robot.qpos_adr)
        self._write_v = writer(data.qvel, robot.dof_adr)

    def take_over(self, previous: Controller) -> None:
        """Continue from another controller of the vendor with the same reference."""
        self.reference, self.payload = previous.reference, previous.payload
        self._carried = previous._carried

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Send changes of the payload to the arm."""
        payload = self.reference.payload
        if payload is not self._carried:
            self.payload = self._carried = payload
            self._connection.set_payload(payload)

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Write the measured state, and advance the reference."""
        self._reading = reading = self._connection.take()
        self.tau = reading.tau
        self._write_q(reading.q)
        self._write_v(reading.v)
        if self.robot.gripper is not None:
            self.robot.gripper.follow_tool(self.bare_model.pose(reading.q))
        self.reference.advance(self._dt)
