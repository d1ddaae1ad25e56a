"""References for controllers while an agent acts."""

from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.control import Controller, Reference
from bt_manip.robots import Payload, Robot, RobotModel

MAX_LAG = 0.1
"""Largest distance of the reference from the measured joints at the start of a motion [rad]."""


def end_velocity(change: np.ndarray, before: np.ndarray, duration: float) -> np.ndarray:
    """Return the velocity at the end of the parabola through three targets [rad/s].

    Args:
        change: Change from the second target to the third [rad].  # (nq,)
        before: Change from the first to the second [rad].  # (nq,)
        duration: Time between two targets [s].
    """  # (nq,)
    return (3.0 * change - before) / (2.0 * duration)


class StepReference(Reference):
    """A joint motion commanded one step of an agent at a time.

    Each step is a cubic from the present reference position and velocity to the target. Its final
    velocity is the derivative of the parabola through the last three targets, so that targets on a
    smooth trajectory reproduce that trajectory. `Arm.servo`, for policies in trees, also respects
    acceleration, jerk and effort limits; it therefore lags behind recorded targets and doubles the
    computing time of a step.

    Args:
        model: The arm.
        steps: Number of control steps in a step of the agent.
        dt: Duration of a control step [s].

    Attributes:
        q: Position [rad].  # (nq,)
        v: Velocity [rad/s].  # (nq,)
        a: Acceleration [rad/s2].  # (nq,)
        payload: The held object; None for nothing.
        T_wt: Commanded pose of the tool; None where joints are commanded.
    """

    def __init__(self, q: np.ndarray, model: RobotModel, steps: int, dt: float) -> None:
        self.payload = None
        self.T_wt: pin.SE3 | None = None
        self._limits, self._duration = model.limits, steps * dt
        s = np.linspace(0.0, 1.0, steps + 1)[:, np.newaxis]
        zero = np.zeros_like(s)
        # Hermite polynomials of start, end and their velocities, and two derivatives.
        hermite = (
            (2 * s**3 - 3 * s**2 + 1, -2 * s**3 + 3 * s**2, s**3 - 2 * s**2 + s, s**3 - s**2),
            (6 * s**2 - 6 * s, -6 * s**2 + 6 * s, 3 * s**2 - 4 * s + 1, 3 * s**2 - 2 * s),
            (12 * s - 6, -12 * s + 6, 6 * s - 4, 6 * s - 2 + zero),
        )
        T = self._duration
        self._basis = np.stack(
            [np.hstack(rows) * [1.0, 1.0, T, T] / T**i for i, rows in enumerate(hermite)], axis=1
        ).reshape(-1, 4)  # (3 (steps + 1), 4)
        self._now = np.zeros(3 * len(q))  # flat, for faster copies
        self.q, self.v, self.a = self._now.reshape(3, -1)
        self.hold_at(q)

    def hold_at(self, q: np.ndarray) -> None:
        """Rest at a configuration [rad]."""
        self._now[:] = 0.0
        self.q[:] = q
        self._before = self.q.copy()
        self._setpoints = np.empty((0, 3 * len(q)))
        self._step = 0

    def move_to(self, q: np.ndarray, measured: np.ndarray, *, uniformly: bool = False) -> None:
        """Move to a configuration within one step.

        Args:
            q: The target [rad].  # (nq,)
            measured: Measured positions, which limit the reference to within `MAX_LAG` [rad].
            uniformly: Whether to scale the motion of all joints down if one is too fast, instead of
                clipping that joint.
        """
        T, limits = self._duration, self._limits
        start = self.q.clip(measured - MAX_LAG, measured + MAX_LAG)
        if (start != self.q).any():  # blocked: continue near the measured joints
            self._before = start.copy()
            self.v[start != self.q] = 0.0
        move, most = q.clip(limits.lower, limits.upper) - start, limits.velocity * T
        if uniformly:
            move = move / max(1.0, float((np.abs(move) / most).max()))
        end = start + move.clip(-most, most)
        v_end = end_velocity(end - start, start - self._before, T)
        v_end = v_end.clip(-limits.velocity, limits.velocity)
        setpoints = self._basis @ np.array([start, end, self.v, v_end])
        self._setpoints = setpoints.reshape(-1, 3 * len(start))
        self._before, self._step = start, 0
        self._now[:] = self._setpoints[0]

    def advance(self, dt: float) -> None:
        """Advance by one control step; rest at the end of the motion."""
        self._step = step = self._step + 1
        if step < len(self._setpoints):
            self._now[:] = self._setpoints[step]

    def finish(self) -> np.ndarray:
        """Complete the motion at once; return its positions, velocities and accelerations."""
        setpoints, self._step = self._setpoints, len(self._setpoints)
        self._now[:] = setpoints[-1]
        n = len(setpoints) - 1
        return setpoints[:-1].reshape(n, 3, -1).swapaxes(0, 1)  # (3, steps, nq)

    def get_state(self) -> Any:
        """Return the state between two steps, as plain data."""
        return {
            "now": self._now.tolist(),
            "before": self._before.tolist(),
            "payload": None if self.payload is None else self.payload.get_state(),
            "T_wt": None if self.T_wt is None else self.T_wt.homogeneous.tolist(),
        }

    def set_state(self, state: Any) -> None:
        """Restore a state of `get_state`."""
        self._now[:] = state["now"]
        self._before = np.array(state["before"])
        self._setpoints = self._setpoints[:0]
        held, T_wt = state["payload"], state["T_wt"]
        self.payload = None if held is None else Payload.from_state(held)
        self.T_wt = None if T_wt is None else pin.SE3(np.array(T_wt))


class TorqueCommand(Controller):
    """Commanded torques, added to gravity and Coriolis compensation.

    Attributes:
        command: The torques [N m].  # (nv,)
    """

    kind = "torque_command"
    saturates = True

    def _build(self, robot: Robot) -> None:
        """Build the controller, with zero torques commanded."""
        super()._build(robot)
        self.command = np.zeros(len(robot.description.arm_joints))

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the torques [N m]."""  # (nv,)
        return self.model.rnea(q, v, np.zeros_like(q)) + self.command
