"""The stages of MoveIt's Task Constructor, as sequences of motions of our own."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.bt import InOut, Input, Output
from bt_manip.exceptions import MotionError
from bt_manip_moveit_pro.leaf import Leaf, RobotLeaf
from bt_manip_moveit_pro.motions import PlanCartesianPath, PlanExecution, plan_of
from bt_manip_moveit_pro.poses import configuration, pose_of
from bt_manip_moveit_pro.values import Motion, Plan, Task, texts, transforms

PLANNING = (
    "acceleration_scale_factor link_padding max_iterations monitored_stage seed "
    "trajectory_sampling_rate orientation_constraint"
)
"""Ports of stages that plan a motion, without effect here."""


class InitializeMTCTask(Leaf):
    """Write a task without stages."""

    ignored = "task_id timeout"
    task = Output(doc="the task")

    def run(self) -> None:
        """Write it."""
        self.task = Task()


class Stage(RobotLeaf):
    """A leaf that adds a stage to a task; a subclass gives its `values`."""

    task = InOut(doc="the task")

    def run(self) -> None:
        """Add the stage."""
        task = self.task
        if not isinstance(task, Task):
            raise ValueError(f"a task is expected, not {type(task).__name__}")
        self.task = task.with_stage(type(self).__name__, **self.values())

    def values(self) -> Mapping[str, Any]:
        """Return the values of the stage.

        Raises:
            ValueError: If one is wrong.
        """
        return {}


class SetupMTCCurrentState(Stage):
    """Let a task begin where the arm is."""


class SetupMTCSetCollisionRule(Stage):
    """Add a stage without effect: contacts are allowed where a motion begins in contact."""

    ignored = "name_a name_b allow_collision"


class SetupMTCConnectWithProRRT(Stage):
    """Add a motion that connects the stages before and after it."""

    ignored = f"{PLANNING} velocity_scale_factor"
    planning_group_name = Input(str, default="manipulator", doc="group of joints")


class SetupMTCPlanToPose(Stage):
    """Add a motion to a pose of the tool."""

    ignored = PLANNING
    target_pose = Input(doc="the pose")
    ik_frame = Input(str, default="grasp_link", doc="name of the link: the tool")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    velocity_scale_factor = Input(float, default=1.0, doc="fraction of the limits", above=0.0)

    def values(self) -> Mapping[str, Any]:
        """Return the pose and the speed."""
        T = self.in_world(pose_of(self.target_pose))
        return {"poses": texts([T]), "speed": min(self.velocity_scale_factor, 1.0)}


class SetupMTCPlanToRobotState(Stage):
    """Add a motion to joint positions."""

    ignored = PLANNING
    joint_state = Input(doc="the joint state")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    velocity_scale_factor = Input(float, default=1.0, doc="fraction of the limits", above=0.0)

    def values(self) -> Mapping[str, Any]:
        """Return the joint positions and the speed."""
        q = configuration(self, self.joint_state)
        return {"q": tuple(q.tolist()), "speed": min(self.velocity_scale_factor, 1.0)}


class SetupMTCCartesianMoveToRobotState(Stage):
    """Add a straight motion of the tool to where it is at joint positions."""

    joint_state = Input(doc="the joint state")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")

    def values(self) -> Mapping[str, Any]:
        """Return the pose of the tool."""
        T = self.arm.model.pose(configuration(self, self.joint_state))
        return {"path": texts([T])}


class SetupMTCMoveAlongFrameAxis(Stage):
    """Add a straight motion of the tool along an axis of a frame."""

    ignored = "acceleration_scale ignore_environment_collisions"
    axis_frame = Input(str, default="world", doc="name of the frame")
    hand_frame = Input(str, default="grasp_link", doc="name of the link: the tool")
    axis_x = Input(float, default=0.0, doc="x of the axis")
    axis_y = Input(float, default=0.0, doc="y of the axis")
    axis_z = Input(float, default=1.0, doc="z of the axis")
    min_distance = Input(float, doc="distance that has to be possible", unit="m")
    max_distance = Input(float, doc="distance", unit="m")
    velocity_scale = Input(float, default=1.0, doc="fraction of the limits", above=0.0)
    planning_group_name = Input(str, default="manipulator", doc="group of joints")

    def values(self) -> Mapping[str, Any]:
        """Return the motion in the frame: that of the tool, or the world."""
        axis = np.array([self.axis_x, self.axis_y, self.axis_z])
        if not axis.any():
            raise ValueError("the axis has no direction")
        shift = axis / np.linalg.norm(axis) * self.max_distance
        tool = self.axis_frame == self.hand_frame
        if not tool:
            shift = self.frame(self.axis_frame).rotation @ shift
        speed = min(self.velocity_scale, 1.0)
        return {"shift": tuple(shift.tolist()), "tool": tool, "speed": speed}


class SetupMTCBatchPoseIK(Stage):
    """Add poses of the tool of which one is reached: the end of the stages before it."""

    ignored = "end_effector_group ik_timeout_s max_ik_solutions monitored_stage"
    target_poses = Input(doc="the poses")
    end_effector_link = Input(str, default="grasp_link", doc="name of the link: the tool")
    ik_group = Input(str, default="manipulator", doc="group of joints")

    def values(self) -> Mapping[str, Any]:
        """Return the poses."""
        poses = [self.in_world(pose_of(pose)) for pose in self.target_poses]
        if not poses:
            raise ValueError("there are no poses to reach")
        return {"ends": texts(poses)}


class SetupMTCPathIK(PlanCartesianPath):
    """Add a motion of the tool through poses on straight lines."""

    ignored = "ignore_environment_collisions"
    task = InOut(doc="the task")

    def run(self) -> None:
        """Add the stage."""
        task = self.task
        if not isinstance(task, Task):
            raise ValueError(f"a task is expected, not {type(task).__name__}")
        poses = [pose_of(pose) for pose in self.path_]
        targets = self.targets(poses, self.tip_offset, self.position_only)
        speed = min(self.velocity_scale_factor, 1.0)
        motions = self.motions(targets, self.blending_radius, speed)
        self.task = task.with_stage("motions", motions=motions)


class SetupMTCFromSolution(Stage):
    """Add the motions of a solution."""

    solution = Input(doc="the solution")

    def values(self) -> Mapping[str, Any]:
        """Return the motions."""
        return {"motions": plan_of(self.solution).motions}


class PlanMTCTask(RobotLeaf):
    """Turn the stages of a task into motions, and check that their poses can be reached.

    A stage of poses (SetupMTCBatchPoseIK) is the end of the straight motions before it, up to the
    connecting stage: that one moves to where they begin.
    """

    ignored = "max_solutions"
    task = Input(doc="the task")
    solution = Output(doc="its motions")

    def run(self) -> None:
        """Write the motions."""
        task = self.task
        if not isinstance(task, Task):
            raise ValueError(f"a task is expected, not {type(task).__name__}")
        stages = list(enumerate(task.stages))
        motions: list[Motion] = []
        T = self.T_wt
        ends = [i for i, (_, values) in stages if "ends" in values]
        if ends:
            names = [name for name, _ in task.stages[: ends[0]]]
            connect = "SetupMTCConnectWithProRRT"
            first = names.index(connect) if connect in names else ends[0]
            motions, T = self.approach(stages[first : ends[0]], task.stages[ends[0]][1]["ends"])
            stages = stages[ends[0] + 1 :]
        for index, (_, values) in stages:
            made, T = self.motion(values, T)
            motions += [replace(motion, stage=index) for motion in made]
        if not motions:
            raise ValueError("the task has no motion")
        self.solution = Plan(tuple(motions))

    def approach(
        self, stages: Sequence[tuple[int, tuple[str, Mapping[str, Any]]]], ends: tuple[str, ...]
    ) -> tuple[list[Motion], pin.SE3]:
        """Return the motions to the first of some poses that can be reached, and that pose.

        Args:
            stages: The stage that connects, and the straight motions that end at a pose.
            ends: The poses.

        Raises:
            MotionError: If none can be reached.
        """
        straight = [(index, values) for index, (_, values) in stages if "shift" in values]
        length = sum(float(np.linalg.norm(values["shift"])) for _, values in straight)
        reason = ""
        for T_end in transforms(ends):
            path = [T_end]
            for _, values in reversed(straight):
                path.append(shifted(path[-1], values, -1.0))
            path.reverse()
            try:
                q = self.arm.robot.q
                for T in path:
                    q = self.require_solution(T, q)
            except MotionError as error:
                reason = str(error)
                continue
            first = Motion(
                poses=texts(path[:1]), approach=length, stage=stages[0][0] if stages else 0
            )
            lines = [
                Motion(path=texts([T]), speed=values["speed"], stage=index)
                for T, (index, values) in zip(path[1:], straight, strict=True)
            ]
            return [first, *lines], T_end
        raise MotionError(f"no pose can be reached: {reason}", reason="unreachable")

    def motion(self, values: Mapping[str, Any], T: pin.SE3) -> tuple[list[Motion], pin.SE3]:
        """Return the motions of a stage that begins with the tool at a pose, and where it ends.

        Raises:
            MotionError: If a pose cannot be reached.
        """
        speed = values.get("speed", 1.0)
        if "motions" in values:
            made = list(values["motions"])
            for motion in made:
                T = self.end_of(motion, T)
            return made, T
        if "q" in values:
            made = [Motion(q=values["q"], speed=speed)]
        elif "poses" in values:
            self.require_solution(transforms(values["poses"])[0], self.arm.robot.q)
            made = [Motion(poses=values["poses"], speed=speed)]
        elif "path" in values or "shift" in values:
            path = values.get("path") or texts([shifted(T, values)])
            self.require_solution(transforms(path)[-1], self.arm.robot.q)
            made = [Motion(path=path, speed=speed)]
        else:
            return [], T
        return made, self.end_of(made[0], T)

    def end_of(self, motion: Motion, T: pin.SE3) -> pin.SE3:
        """Return the pose of the tool at the end of a motion."""
        if motion.q:
            return self.arm.model.pose(np.array(motion.q))
        if motion.poses or motion.path:
            return transforms((motion.path or motion.poses)[-1:])[0]
        return T


def shifted(T: pin.SE3, values: Mapping[str, Any], factor: float = 1.0) -> pin.SE3:
    """Return a pose moved by the shift of a stage [m], along its own axes or the world's."""
    shift = factor * np.array(values["shift"])
    return T * pin.SE3(np.eye(3), shift) if values["tool"] else pin.SE3(np.eye(3), shift) * T


class ExecuteMTCSolution(PlanExecution):
    """Execute the motions of a solution."""

    plan_port = "solution"
    ignored = (
        "controller_action_name execution_pipeline goal_duration_tolerance "
        "goal_position_tolerance path_position_tolerance absolute_force_torque_threshold "
        "admittance_parameters_msg"
    )
    solution = Input(doc="the solution")


class WaitForMTCSolutionApproval(Leaf):
    """Succeed with a solution: it is approved."""

    ignored = "cartesian_path_links"
    solution = Input(default="", doc="the solution")


class SplitMTCSolution(Leaf):
    """Split a solution before a stage."""

    solution_in = Input(doc="the solution")
    index = Input(int, doc="index of the first stage of the other part, from 0", at_least=0)
    solution_out_1 = Output(doc="the first part")
    solution_out_2 = Output(doc="the other part")

    def run(self) -> None:
        """Write the parts."""
        motions, index = plan_of(self.solution_in).motions, self.index
        self.solution_out_1 = Plan(tuple(m for m in motions if m.stage < index))
        self.solution_out_2 = Plan(tuple(m for m in motions if m.stage >= index))


class ConvertMtcSolutionToJointTrajectory(Leaf):
    """Write a solution as a plan: it is one."""

    solution = Input(doc="the solution")
    joint_trajectory = Output(doc="the plan")

    def run(self) -> None:
        """Write it."""
        self.joint_trajectory = plan_of(self.solution)
