"""Actions of arms and grippers: joint torques, joint targets, tool displacements."""

import abc
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import payload_of
from bt_manip.bt import NodeStatus
from bt_manip.cell import Cell
from bt_manip.exceptions import BtManipError
from bt_manip.robots import Gripper, Payload
from bt_manip.runner import CommandedRobot

from .actions import ActionKind, ActionSpace
from .differential_ik import differential_ik
from .episodes import Episodes
from .references import StepReference, TorqueCommand

MAX_ANGLE = 2.0 * np.pi
"""Bound of targets of joints without position limits [rad]."""

MAX_TOOL_SPEED = 2.0
"""Bound of commanded tool displacements, per step time [m/s]."""

MAX_TOOL_TURNING = 4.0 * np.pi
"""Bound of commanded tool rotations, per step time [rad/s]."""

MAX_TOOL_LAG = 0.05
"""Largest tool pose error at which displacements start at the commanded pose [m], [rad]."""


def displaced(T_wt: pin.SE3, delta: np.ndarray) -> pin.SE3:
    """Return a pose after a displacement [m] and a rotation vector [rad] in world axes."""  # (6,)
    return pin.SE3(pin.exp3(delta[3:]) @ T_wt.rotation, T_wt.translation + delta[:3])


def command_gripper(gripper: Gripper, close: bool) -> None:
    """Close or open a gripper, unless it is doing so or has done so."""
    if close and not gripper.gripping:
        gripper.close(gripper.default_force())
    elif not close and (gripper.gripping or not (gripper.moving or gripper.is_open)):
        gripper.open()


def held_payload(
    cell: Cell, gripper: Gripper, T_wt: pin.SE3, before: Payload | None
) -> Payload | None:
    """Return the payload of an agent's arm, computed once the grasp is steady.

    Args:
        cell: The cell.
        gripper: The gripper.
        T_wt: Pose of the tool in the world.
        before: The previous payload; None for nothing.
    """
    held = [name for name in gripper.held if cell.is_free(name)] if gripper.gripping else []
    if not held:
        return None
    if before is None and gripper.steady:
        return payload_of(cell, held[0], T_wt)
    return before


class ArmAction(ActionKind):
    """An action with values for each arm, and one in [-1, 1] for its gripper.

    A positive gripper value closes, others open. Its magnitude sets the time in the step, from 1,
    at the start, to 0, at the end.
    """

    def __init__(self, episodes: Episodes) -> None:
        super().__init__(episodes)
        values: list[tuple[float, float, str, str]] = []  # low, high, name and unit of each
        self._counts: dict[str, int] = {}  # values of each arm
        for one in self._robots:
            label = "robot" if len(self._robots) == 1 else one.name
            low, high, names, units = self._bounds(one)
            self._counts[one.name] = len(names)
            labelled = [f"{label}_{name}" for name in names]
            values += zip(low, high, labelled, units, strict=True)
            if one.gripper is not None:
                values.append((-1.0, 1.0, f"{label}_gripper", "-"))
        lows, highs, all_names, all_units = zip(*values, strict=True)
        as_array = np.array(lows, np.float32), np.array(highs, np.float32)
        self.space = ActionSpace(*as_array, all_names, all_units)
        self._references: list[StepReference] = []
        self._late: list[tuple[int, CommandedRobot, bool]] = []  # with ticks until the command

    @abc.abstractmethod
    def _bounds(self, one: CommandedRobot) -> tuple[Any, Any, list[str], list[str]]:
        """Return lower bounds, upper bounds, names and units for one arm."""

    @abc.abstractmethod
    def _move(self, one: CommandedRobot, reference: StepReference, numbers: np.ndarray) -> None:
        """Command one arm for the coming step."""

    @abc.abstractmethod
    def _recorded(self, index: int, one: CommandedRobot) -> np.ndarray:
        """Return the values of one arm for the observed step."""

    def command(self, action: Any) -> None:
        """Command the arms and grippers; see `ActionKind.step`."""
        action = np.asarray(action, dtype=float)
        if action.shape != self.space.shape or not np.isfinite(action).all():
            raise BtManipError(
                f"an action consists of {len(self.space.low)} finite numbers "
                f"({', '.join(self.space.names)}), got {action}"
            )
        numbers = np.clip(action, self.space.low, self.space.high)
        self.take_over()
        at = 0
        self._late = []
        for one, reference in zip(self._robots, self._references, strict=True):
            n = self._counts[one.name]
            self._move(one, reference, numbers[at : at + n])
            at += n
            if one.gripper is not None:
                close = bool(numbers[at] > 0.0)
                delay = round((1.0 - abs(numbers[at])) * self._episodes.ticks)
                if delay and close != one.gripper.gripping:
                    self._late.append((delay, one, close))
                else:
                    self._grip(one, reference, close)
                at += 1

    def tick(self) -> NodeStatus:
        """Execute the delayed gripper commands that are due."""
        for delay, one, close in self._late:
            if delay == 0:
                self._grip(one, None, close)
        self._late = [(delay - 1, one, close) for delay, one, close in self._late]
        return NodeStatus.RUNNING

    @property
    def waiting(self) -> bool:
        """Whether a gripper command is pending in the step."""
        return bool(self._late)

    def take_over(self) -> list[StepReference]:
        """Take the robots over from the tree, once per episode; return their references.

        The first command of an episode calls it.
        """
        if self._acts:
            return self._references
        self._episodes.release()
        dt = self._episodes.station.cell.dt
        steps = round(self._episodes.step_time / dt)
        self._references = [
            StepReference(one.arm.q, one.arm.model, steps, dt) for one in self._robots
        ]
        for one, reference in zip(self._robots, self._references, strict=True):
            reference.payload = one.arm.payload
            one.controllers.reference = reference
        return self._references

    def follow(self, references: list[StepReference]) -> None:
        """Let the robots follow references taken over in another episode."""
        self._references = references
        for one, reference in zip(self._robots, references, strict=True):
            one.controllers.reference = reference

    def recorded(self) -> np.ndarray:
        """Return the action that reproduces the step since `watch`."""
        numbers: list[float] = []
        for i, one in enumerate(self._robots):
            numbers += self._recorded(i, one).tolist()
            if one.gripper is not None:
                late = self._episodes.gripped.get(one.name, 0) / self._episodes.ticks
                numbers.append((1.0 - late) * (1.0 if one.gripper.gripping else -1.0))
        return np.array(numbers, dtype=np.float32)

    def get_state(self) -> Any:
        """Return the references; None before the first action of an episode."""
        return [one.get_state() for one in self._references] if self._acts else None

    def set_state(self, state: Any) -> None:
        """Restore a state of `get_state`."""
        if state is not None:
            for reference, values in zip(self.take_over(), state, strict=True):
                reference.set_state(values)

    @property
    def _acts(self) -> bool:
        """Whether the robots follow these references instead of the arms."""
        return bool(self._references) and all(
            one.controllers.reference is reference
            for one, reference in zip(self._robots, self._references, strict=True)
        )

    def _grip(self, one: CommandedRobot, reference: StepReference | None, close: bool) -> None:
        """Open or close the gripper; set the payload of the reference."""
        gripper, cell = one.robot.needed_gripper, self._episodes.station.cell
        command_gripper(gripper, close)
        if reference is not None:
            T_wt = one.arm.model.pose(one.robot.q)
            reference.payload = held_payload(cell, gripper, T_wt, reference.payload)


class JointTargets(ArmAction):
    """Joint positions at the end of the step [rad], and the gripper.

    The reference reaches them along a cubic, whose final velocity follows from the present and the
    last two targets. Targets that the velocity limits do not allow within the step are clipped.
    """

    kind = "joint_targets"

    def _bounds(self, one: CommandedRobot) -> tuple[Any, Any, list[str], list[str]]:
        limits = one.arm.model.limits
        low, high = np.maximum(limits.lower, -MAX_ANGLE), np.minimum(limits.upper, MAX_ANGLE)
        return low, high, list(one.robot.description.arm_joints), list(one.arm.model.units)

    def _move(self, one: CommandedRobot, reference: StepReference, numbers: np.ndarray) -> None:
        reference.move_to(numbers, one.robot.q)

    def _recorded(self, index: int, one: CommandedRobot) -> np.ndarray:
        return one.controllers.reference.q.copy()


class CartesianDeltas(ArmAction):
    """Displacement [m] and rotation vector [rad] of the tool, in world axes, and the gripper.

    They are relative to the last commanded pose; in the first step, and where the arm could not
    follow, to the pose of the reference. Differential inverse kinematics gives the joint targets.
    """

    kind = "cartesian_deltas"

    def _bounds(self, one: CommandedRobot) -> tuple[Any, Any, list[str], list[str]]:
        step = self._episodes.step_time
        high = np.repeat([MAX_TOOL_SPEED * step, MAX_TOOL_TURNING * step], 3)
        names = ["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]
        return -high, high, names, ["m"] * 3 + ["rad"] * 3

    def _move(self, one: CommandedRobot, reference: StepReference, numbers: np.ndarray) -> None:
        model, q = one.arm.model, reference.q
        T, last = model.pose(q), reference.T_wt
        if last is not None and np.abs(pin.log6(T.actInv(last)).vector).max() < MAX_TOOL_LAG:
            T = last
        T = displaced(T, numbers)
        reference.move_to(differential_ik(model, q, T), one.robot.q, uniformly=True)
        reference.T_wt = T

    def watch(self) -> None:
        """Begin to observe a step of the expert."""
        self._before = [one.arm.model.pose(one.controllers.reference.q) for one in self._robots]

    def _recorded(self, index: int, one: CommandedRobot) -> np.ndarray:
        before, now = self._before[index], one.arm.model.pose(one.controllers.reference.q)
        turned = pin.log3(now.rotation @ before.rotation.T)
        return np.concatenate([now.translation - before.translation, turned])


class JointTorques(ArmAction):
    """Joint torques added to gravity and Coriolis compensation, and the gripper.

    The sum is clipped to the effort limits; the added torques are constant during the step.
    """

    kind = "joint_torques"

    def _bounds(self, one: CommandedRobot) -> tuple[Any, Any, list[str], list[str]]:
        effort = one.arm.model.limits.effort
        units = ["N" if unit == "m" else "N m" for unit in one.arm.model.units]
        return -effort, effort, list(one.robot.description.arm_joints), units

    def __init__(self, episodes: Episodes) -> None:
        super().__init__(episodes)
        for one in self._robots:
            one.controllers.add(TorqueCommand.kind, TorqueCommand)

    def take_over(self) -> list[StepReference]:
        """Take the robots over, and activate the torque controller."""
        references = super().take_over()
        for one in self._robots:
            if one.controllers.active != TorqueCommand.kind:
                one.controllers.activate(TorqueCommand.kind)
        return references

    def _move(self, one: CommandedRobot, reference: StepReference, numbers: np.ndarray) -> None:
        one.controllers.controller.command = numbers

    def watch(self) -> None:
        """Begin to observe a step of the expert."""
        self._before_torques = [
            one.robot.tau - one.arm.model.rnea(one.robot.q, one.robot.v, np.zeros_like(one.robot.q))
            for one in self._robots
        ]

    def _recorded(self, index: int, one: CommandedRobot) -> np.ndarray:
        return self._before_torques[index]
