"""Faults of the robot: external forces, joints, fingers, sensors, motors."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np

from bt_manip.cell import entity_of

from .fault import Fault, FaultContext, FaultError, parameter

LOCKING_FRICTION = 1e4
"""Dry friction larger than all motor efforts and forces in a cell [N m or N]."""

LOST_GAIN = 1e-9
"""Factor on the torque of a motor without power; overrides do not accept 0."""


@dataclass
class Push(Fault):
    """A horizontal force in a random direction acts on a link of the arm."""

    force: float = parameter(100.0, "Force [N].")
    duration: float = parameter(2.0, "Time for which it acts [s].")
    link: str = parameter("", "Body of the robot that is pushed; by default the last link.")

    def begin(self) -> None:
        """Choose the direction."""
        angle = self.context.rng.uniform(-math.pi, math.pi)
        self._vector = self.force * np.array([math.cos(angle), math.sin(angle), 0.0])
        self._body()  # raises an error if there is no such link
        self.at_end(self._apply, np.zeros(3))

    def bind(self) -> None:
        """Apply the force; it acts until it is changed."""
        self._apply(self._vector)

    def _apply(self, force: np.ndarray) -> None:
        self.context.cell.data.xfrc_applied[self._body(), :3] = force

    def _body(self) -> int:
        robot = self.context.robot
        if self.link:
            return self.context.cell.body_id(f"{robot.name}/{self.link}")
        return robot.robot.wrist_body_id


def _choose_joint(context: FaultContext, part: str, joints: list[int], number: int) -> int:
    """Return one of the joints of a part by its number from 1, or a random one for 0."""
    if not joints or number > len(joints):
        raise FaultError(f"the {part} has {len(joints)} joints, got joint {number}")
    return joints[context.rng.integers(len(joints)) if number == 0 else number - 1]


class _Lock(Fault):
    """Locks joints of the robot by dry friction."""

    def lock(self, dof: int) -> None:
        """Lock a degree of freedom of the model until the fault ends."""
        cell, name = self.context.cell, self.context.robot.name
        friction = list(cell.nominal(name, "joint_friction"))
        friction[self.dofs().index(dof)] = LOCKING_FRICTION
        self.override(name, joint_friction=friction)

    def dofs(self) -> list[int]:
        """Return the degrees of freedom of the robot and its gripper."""
        model, name = self.context.cell.model, self.context.robot.name
        owners = [entity_of(model.body(body).name) for body in model.dof_bodyid]
        return [dof for dof, owner in enumerate(owners) if owner == name]


@dataclass
class StuckJoint(_Lock):
    """A joint of the arm does not move."""

    joint: int = parameter(0, "Number of the joint, from 1; 0: a random one.")
    duration: float = parameter(1.0, "Time for which it is stuck [s].")

    def begin(self) -> None:
        """Lock the joint."""
        arm = self.context.robot.robot.dof_adr.tolist()
        self.lock(_choose_joint(self.context, "arm", arm, self.joint))


@dataclass
class StuckFinger(_Lock):
    """A joint of the gripper does not move."""

    finger: int = parameter(0, "Number of the gripper's joint, from 1; 0: a random one.")
    duration: float = parameter(1.0, "Time for which it is stuck [s].")

    def begin(self) -> None:
        """Lock the joint."""
        arm = self.context.robot.robot.dof_adr.tolist()
        fingers = [dof for dof in self.dofs() if dof not in arm]
        self.lock(_choose_joint(self.context, "gripper", fingers, self.finger))


@dataclass
class TorqueLoss(Fault):
    """The motors of the arm have no torque; the gripper keeps its own."""

    duration: float = parameter(0.2, "Time without torque [s].")

    def begin(self) -> None:
        """Override the gains of the motors."""
        cell, robot = self.context.cell, self.context.robot
        model, body = cell.model, int(mujoco.mjtTrn.mjTRN_BODY)
        motors = [
            i
            for i in range(model.nu)
            if entity_of(model.actuator(i).name) == robot.name and model.actuator_trntype[i] != body
        ]
        arm = set(robot.robot.ctrl_adr.tolist())
        self.override(robot.name, gain=[LOST_GAIN if i in arm else 1.0 for i in motors])


class _SensorFault(Fault):
    """Replaces the measured joint state for arm and controller."""

    def measure(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the faulty measurement for a true state; called once per control step."""
        raise NotImplementedError

    def begin(self) -> None:
        """Schedule the return to true values at the end."""
        robot = self.context.robot.robot
        if isinstance(getattr(robot.read_q, "__self__", None), _SensorFault):
            raise FaultError("the sensors have a fault already")
        self._time, self._measured = -math.inf, (robot.q, robot.v)
        self.at_end(lambda: self._set(self._read_q, self._read_v))

    def bind(self) -> None:
        """Replace the read functions of the present model."""
        robot, data = self.context.robot.robot, self.context.cell.data
        if getattr(robot.read_q, "__self__", None) is self:
            return  # bound already
        self._read_q, self._read_v, self._data = robot.read_q, robot.read_v, data
        self._set(self.read_q, self.read_v)

    def read_q(self) -> np.ndarray:
        """Return the measured positions [rad]."""  # (nq,)
        return self._read()[0]

    def read_v(self) -> np.ndarray:
        """Return the measured velocities [rad/s]."""  # (nq,)
        return self._read()[1]

    def _read(self) -> tuple[np.ndarray, np.ndarray]:
        if self._data.time != self._time:  # arm and controller read the same values
            self._time = self._data.time
            self._measured = self.measure(self._read_q().copy(), self._read_v().copy())
        return self._measured

    def _set(self, q: Callable[[], np.ndarray], v: Callable[[], np.ndarray]) -> None:
        robot = self.context.robot.robot
        robot.read_q, robot.read_v = q, v


@dataclass
class SensorNoise(_SensorFault):
    """White noise is added to the measured positions and velocities of the joints."""

    position: float = parameter(2e-5, "Standard deviation of the positions [rad].")
    velocity: float = parameter(2e-3, "Standard deviation of the velocities [rad/s].")

    def measure(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Add noise."""
        noise = self.context.rng.standard_normal((2, len(q)))
        return q + self.position * noise[0], v + self.velocity * noise[1]


@dataclass
class SensorDelay(_SensorFault):
    """The measured positions and velocities of the joints are delayed."""

    delay: float = parameter(0.002, "Their age [s].")

    def begin(self) -> None:
        """Clear past measurements."""
        super().begin()
        steps = round(self.delay / self.context.cell.dt)
        self._past: deque[tuple[np.ndarray, np.ndarray]] = deque(maxlen=steps + 1)

    def measure(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return an earlier state."""
        self._past.append((q, v))
        return self._past[0]


@dataclass
class SensorNaN(_SensorFault):
    """The measured position of a joint is not a number."""

    joint: int = parameter(0, "Number of the joint, from 1; 0: a random one.")
    duration: float = parameter(0.01, "Time for which it is not a number [s].")

    def begin(self) -> None:
        """Choose the joint."""
        super().begin()
        joints = list(range(len(self._measured[0])))
        self._index = _choose_joint(self.context, "arm", joints, self.joint)

    def measure(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Replace the position."""
        q[self._index] = math.nan
        return q, v
