"""The stages of MoveIt's Task Constructor, as sequences of motions of our own."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.bt import InOut, Input, Output
from bt_manip.exceptions import MotionError
from bt_manip_moveit_pro.leaf import Leaf, RobotLeaf
from bt_manip_moveit_pro.motions import PlanExecution
from bt_manip_moveit_pro.values import Motion, Plan, expect

PLANNING = (
    "acceleration_scale_factor link_padding max_iterations monitored_stage seed "
    "trajectory_sampling_rate orientation_constraint"
)
"""Ports of stages that plan a motion, without effect here."""


class Connect(NamedTuple):
    """A motion that connects the stages before and after it."""


class Ends(NamedTuple):
    """Poses of the tool in the world, one of which ends the straight motions before."""

    poses: tuple[pin.SE3, ...]


class Shift(NamedTuple):
    """A straight motion of the tool by a vector [m], along its own axes or the world's."""

    vector: tuple[float, ...]
    in_tool: bool
    speed: float

    def applied(self, T: pin.SE3, factor: float = 1.0) -> pin.SE3:
        """Return a pose moved by a multiple of the vector."""
        T_shift = pin.SE3(np.eye(3), factor * np.array(self.vector))
        return T * T_shift if self.in_tool else T_shift * T


@dataclass(frozen=True)
class Task:
    """Stages of the MoveIt Task Constructor."""

    stages: tuple[Motion | Shift | Ends | Connect, ...] = ()


class InitializeMTCTask(Leaf):
    """Write a task without stages."""

    ignored = "task_id timeout"
    task = Output(doc="the task")

    def _run(self) -> None:
        self.task = Task()


class Stage(RobotLeaf):
    """A leaf that adds a stage to a task."""

    task = InOut(doc="the task")

    def _run(self) -> None:
        self.task = Task((*expect(self.task, Task).stages, self._stage()))

    def _stage(self) -> Motion | Shift | Ends | Connect:
        raise NotImplementedError


class SetupMTCConnectWithProRRT(Stage):
    """Add a motion that connects the stages before and after it."""

    ignored = f"{PLANNING} velocity_scale_factor"
    planning_group_name = Input(str, default="manipulator", doc="group of joints")

    def _stage(self) -> Connect:
        return Connect()


class SetupMTCPlanToPose(Stage):
    """Add a motion to a pose of the tool."""

    ignored = f"{PLANNING} ik_frame"
    target_pose = Input(doc="the pose")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    velocity_scale_factor = Input(float, default=1.0, doc="fraction of the limits", above=0.0)

    def _stage(self) -> Motion:
        T = self.in_world(self.target_pose)
        return Motion(pose=T, speed=min(self.velocity_scale_factor, 1.0))


class SetupMTCPlanToRobotState(Stage):
    """Add a motion to joint positions."""

    ignored = PLANNING
    joint_state = Input(doc="the joint state")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    velocity_scale_factor = Input(float, default=1.0, doc="fraction of the limits", above=0.0)

    def _stage(self) -> Motion:
        q = self.configuration(self.joint_state)
        return Motion(q=tuple(q.tolist()), speed=min(self.velocity_scale_factor, 1.0))


class SetupMTCCartesianMoveToRobotState(Stage):
    """Add a straight motion of the tool to where it is at joint positions."""

    joint_state = Input(doc="the joint state")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")

    def _stage(self) -> Motion:
        return Motion(path=(self.arm.model.pose(self.configuration(self.joint_state)),))


class SetupMTCMoveAlongFrameAxis(Stage):
    """Add a straight motion of the tool along an axis of a frame."""

    ignored = "acceleration_scale ignore_environment_collisions min_distance"
    axis_frame = Input(str, default="world", doc="name of the frame")
    hand_frame = Input(str, default="grasp_link", doc="name of the link: the tool")
    axis_x = Input(float, default=0.0, doc="x of the axis")
    axis_y = Input(float, default=0.0, doc="y of the axis")
    axis_z = Input(float, default=1.0, doc="z of the axis")
    max_distance = Input(float, doc="distance", unit="m")
    velocity_scale = Input(float, default=1.0, doc="fraction of the limits", above=0.0)
    planning_group_name = Input(str, default="manipulator", doc="group of joints")

    def _stage(self) -> Shift:
        axis = np.array([self.axis_x, self.axis_y, self.axis_z])
        if not axis.any():
            raise ValueError("the axis has no direction")
        shift = axis / np.linalg.norm(axis) * self.max_distance
        in_tool = self.axis_frame == self.hand_frame
        if not in_tool:
            shift = self.frame(self.axis_frame).rotation @ shift
        return Shift(tuple(shift.tolist()), in_tool, min(self.velocity_scale, 1.0))


class SetupMTCBatchPoseIK(Stage):
    """Add poses of the tool of which one is reached: the end of the stages before it."""

    ignored = (
        "end_effector_group end_effector_link ik_group ik_timeout_s max_ik_solutions "
        "monitored_stage"
    )
    target_poses = Input(doc="the poses")

    def _stage(self) -> Ends:
        poses = tuple(self.in_world(pose) for pose in self.target_poses)
        if not poses:
            raise ValueError("there are no poses to reach")
        return Ends(poses)


class PlanMTCTask(RobotLeaf):
    """Turn the stages of a task into motions, and check that their poses can be reached.

    A stage of poses (SetupMTCBatchPoseIK) is the end of the straight motions before it, up to the
    connecting stage: that one moves to where they begin.
    """

    ignored = "max_solutions"
    task = Input(doc="the task")
    solution = Output(doc="its motions")

    def _run(self) -> None:
        stages = expect(self.task, Task).stages
        motions: list[Motion] = []
        T = self.T_wt
        for last, ends in enumerate(stages):
            if isinstance(ends, Ends):
                kinds = [type(stage) for stage in stages[:last]]
                first = kinds.index(Connect) if Connect in kinds else last
                straight = [stage for stage in stages[first:last] if isinstance(stage, Shift)]
                motions, T = self._approach(straight, ends.poses)
                stages = stages[last + 1 :]
                break
        for stage in stages:
            if isinstance(stage, Shift):
                stage = Motion(path=(stage.applied(T),), speed=stage.speed)
            if isinstance(stage, Motion):
                motions.append(stage)
                T = self._end_of(stage)
        if not motions:
            raise ValueError("the task has no motion")
        self.solution = Plan(tuple(motions))

    def _approach(
        self, straight: Sequence[Shift], ends: Sequence[pin.SE3]
    ) -> tuple[list[Motion], pin.SE3]:
        """Return the motions to the first of some poses that can be reached, and that pose."""
        length = sum(float(np.linalg.norm(shift.vector)) for shift in straight)
        for T_end in ends:
            path = [T_end]
            for shift in reversed(straight):
                path.insert(0, shift.applied(path[0], -1.0))
            q = self.arm.robot.q
            try:
                for T in path:
                    q = self.require_solution(T, q)
            except MotionError as error:
                reason = error
                continue
            lines = zip(path[1:], straight, strict=True)
            motions = [Motion(path=(T,), speed=shift.speed) for T, shift in lines]
            return [Motion(pose=path[0], approach=length), *motions], T_end
        raise MotionError(f"no pose can be reached: {reason}", reason="unreachable")

    def _end_of(self, motion: Motion) -> pin.SE3:
        """Return the pose of the tool at the end of a motion, which has to be reachable."""
        if motion.q:
            return self.arm.model.pose(np.array(motion.q))
        T = motion.path[-1] if motion.path else motion.pose
        self.require_solution(T, self.arm.robot.q)
        return T


class ConvertMtcSolutionToJointTrajectory(Leaf):
    """Write a solution as a plan: it is one."""

    solution = Input(doc="the solution")
    joint_trajectory = Output(doc="the plan")

    def _run(self) -> None:
        self.joint_trajectory = expect(self.solution, Plan)


class ExecuteMTCSolution(PlanExecution):
    """Execute the motions of a solution."""

    plan_port = "solution"
    solution = Input(doc="the solution")
