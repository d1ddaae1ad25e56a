"""Leaves that plan and execute motions of the arm and the gripper.

A plan is a list of motions of our own. Leaves that plan check that its poses can be reached; paths
around obstacles are found where the plan is executed.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import MotionBehaviour, payload_of
from bt_manip.bt import Input, Output, Status
from bt_manip.exceptions import MotionError
from bt_manip.planning import LineTo
from bt_manip_moveit_pro.leaf import NUMBERS, NamedRobot, RobotLeaf, UnusedPorts
from bt_manip_moveit_pro.values import JointState, Motion, Plan, expect

JOINT_STEP = 0.2  # [rad] of a joint between two checked poses of a path
LINE_STEP = 0.02  # [m], and half of it in units of 10 rad, between them


class RetrieveWaypoint(RobotLeaf):
    """Get the joint positions of a named configuration."""

    waypoint_name = Input(str, doc="its name")
    joint_group_name = Input(str, default="manipulator", doc="group of joints")
    waypoint_joint_state = Output(doc="its joint state")

    def _run(self) -> None:
        robot, name = self.arm.robot, self.waypoint_name
        found = robot.configurations.get(name)
        if isinstance(found, Mapping):
            self.waypoint_joint_state = JointState(dict(found))
        else:
            self.waypoint_joint_state = self.state_of(robot.configuration(name))


class GetJointState(RobotLeaf):
    """Get the measured joint positions of the arm."""

    ignored = "planning_scene"
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    joint_state = Output(doc="the joint state")

    def _run(self) -> None:
        self.joint_state = self.state_of(self.arm.robot.q)


class SaveCurrentState(RobotLeaf):
    """Get the measured joint positions of the arm."""

    saved_robot_state = Output(doc="the joint state")

    def _run(self) -> None:
        self.saved_robot_state = self.state_of(self.arm.robot.q)


class PlanToJointGoal(RobotLeaf):
    """Plan a motion to joint positions."""

    ignored = (
        "acceleration_scale_factor link_padding max_iterations seed trajectory_sampling_rate "
        "orientation_constraint"
    )
    joint_goal = Input(doc="joint state of the goal")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    velocity_scale_factor = Input(float, default=1.0, doc="fraction of the limits", above=0.0)
    joint_trajectory_msg = Output(default="{joint_trajectory_msg}", doc="the plan")

    def _run(self) -> None:
        q = self.configuration(self.joint_goal)
        self.arm.model.limits.checked(q, self.arm.model.units)
        speed = min(self.velocity_scale_factor, 1.0)
        self.joint_trajectory_msg = Plan((Motion(q=tuple(q.tolist()), speed=speed),))


class GeneratePointToPointTrajectory(PlanToJointGoal):
    """Plan a motion to joint positions."""

    ignored = "jerk_scale_factor start_state start_time"
    joint_goal = Input(name="target_state", doc="joint state of the goal")


class ComputeInverseKinematics(RobotLeaf):
    """Find joint positions that put the tool at a pose."""

    ignored = "ik_timeout_s link_padding planning_scene_msg"
    target_poses = Input(doc="the pose, in a list")
    tip_links = Input(str, default="grasp_link", doc="name of the link: the tool")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    solution = Output(doc="the joint state")

    def _run(self) -> None:
        refuse_several(self.tip_links)
        (pose,) = self.target_poses
        q = self.require_solution(self.in_world(pose), self.arm.robot.q)
        self.solution = self.state_of(q)


def refuse_several(links: str) -> None:
    """Raise a ValueError where a path is for several tools."""
    if ";" in links:
        raise ValueError(f"a path of several arms is not supported: {links}")


class PlanCartesianPath(RobotLeaf):
    """Plan a motion of the tool through poses on straight lines.

    Of several poses, the first is approached around obstacles, with joint positions from which the
    others can be reached. A single pose is reached on a line. With `position_only`, the tool keeps
    its orientation.
    """

    ignored = (
        "trajectory_timing ik_cartesian_space_density ik_joint_space_density "
        "tip_link max_optimizer_iterations acceleration_scale_factor trajectory_sampling_rate"
    )
    path_ = Input(name="path", doc="poses")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    tip_links = Input(str, default="grasp_link", doc="name of the link: the tool")
    tip_offset = Input(
        NUMBERS, default="0;0;0;0;0;0", doc="pose in the tool that passes the path [m], [rad]"
    )
    position_only = Input(bool, default=False, doc="whether the orientation of the poses is free")
    blending_radius = Input(float, default=0.0, doc="distance from corners", unit="m", at_least=0.0)
    velocity_scale_factor = Input(float, default=1.0, doc="fraction of the limits", above=0.0)
    joint_trajectory_msg = Output(default="{joint_trajectory_msg}", doc="the plan")
    debug_solution = Output(default="{debug_solution}", doc="the plan, to be approved")

    def _run(self) -> None:
        refuse_several(self.tip_links)
        offset = self.tip_offset
        T_to = pin.SE3(pin.rpy.rpyToMatrix(*offset[3:]), np.array(offset[:3]))
        targets = [self.in_world(pose) * T_to.inverse() for pose in self.path_]
        if not targets:
            raise ValueError("the path has no poses")
        if self.position_only:
            targets = [pin.SE3(self.T_wt.rotation, T.translation) for T in targets]
        speed, plan = min(self.velocity_scale_factor, 1.0), []
        if len(targets) == 1:
            self.require_solution(targets[0], self.arm.robot.q)
        else:
            plan = [Motion(q=self._start_of(targets))]
            targets = targets[1:]
        plan.append(Motion(path=tuple(targets), blend=self.blending_radius, speed=speed))
        self.joint_trajectory_msg = self.debug_solution = Plan(tuple(plan))

    def _start_of(self, targets: Sequence[pin.SE3]) -> tuple[float, ...]:
        """Return joint positions from which the tool can follow a path [rad]."""
        best = 0.0
        solutions = self.arm.ik.solutions(targets[0], self.arm.robot.q)
        if not solutions:
            self.require_solution(targets[0], self.arm.robot.q)
        for found in solutions:
            share = self._followed(targets, found.q)
            if share == 1.0:
                return tuple(found.q.tolist())
            best = max(best, share)
        raise MotionError(
            f"the path can be followed up to {100 * best:.0f} %", reason="unreachable"
        )

    def _followed(self, targets: Sequence[pin.SE3], q: np.ndarray) -> float:
        """Return the share of a path that can be followed from joint positions."""
        samples = [T for pair in zip(targets, targets[1:], strict=False) for T in line(*pair)]
        for index, T in enumerate(samples):
            found = self.arm.ik.follow(T, q, max_step=JOINT_STEP, retry=False)
            if not found.solved:
                return index / len(samples)
            q = found.q
        return 1.0


def line(start: pin.SE3, end: pin.SE3) -> list[pin.SE3]:
    """Return poses on the straight line between two others, the last one included."""
    motion = pin.log6(start.actInv(end)).vector
    distance = float(np.linalg.norm(end.translation - start.translation))
    angle = float(np.linalg.norm(motion[3:]))
    n = math.ceil(max(distance / LINE_STEP, angle / (5 * LINE_STEP), 1.0))
    return [pin.SE3.Interpolate(start, end, (i + 1) / n) for i in range(n)]


class ValidateTrajectory(RobotLeaf):
    """Succeed with a plan: where it is executed, its motions are checked for collisions."""

    ignored = "cartesian_space_step joint_space_step planning_group_name planning_scene_msg"
    joint_trajectory_msg = Input(default="{joint_trajectory_msg}", doc="the plan")
    debug_solution = Output(default="{debug_solution}", doc="the plan, to be approved")

    def _run(self) -> None:
        self.debug_solution = expect(self.joint_trajectory_msg, Plan)


class PlanExecution(UnusedPorts, MotionBehaviour):
    """Execute the motions of a plan, one after the other."""

    ignored = (
        "controller_action_name execution_pipeline goal_duration_tolerance "
        "goal_position_tolerance path_position_tolerance absolute_force_torque_threshold "
        "admittance_parameters_msg"
    )
    plan_port: ClassVar[str] = ""
    memory: ClassVar[tuple[str, ...]] = (*MotionBehaviour.memory, "_plan", "_next")
    _plan: tuple[Motion, ...] = ()
    _next = 0

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell, the robots and the random generator."""
        super().setup(**infrastructure)
        self._rng = infrastructure["rng"]

    def initialise(self) -> None:
        """Begin with the first motion."""
        try:
            self._plan, self._next = expect(self.read_port(self.plan_port), Plan).motions, 0
        except ValueError as error:
            self.fail(str(error))
        else:
            super().initialise()

    def start(self) -> None:
        """Start the present motion."""
        if self._next >= len(self._plan):
            return
        motion, arm = self._plan[self._next], self.arm
        if motion.q:
            arm.move_to_configuration(motion.q, speed=motion.speed, rng=self._rng)
        elif motion.path:
            arm.move_path([LineTo(T) for T in motion.path], motion.speed, blend=motion.blend)
        else:
            arm.move_to_pose(motion.pose, motion.speed, approach=motion.approach, rng=self._rng)

    def arrived(self) -> Status:
        """Start the next motion, or succeed after the last one."""
        self._next += 1
        if self._next >= len(self._plan):
            return super().arrived()
        return self.begin_motion(self.start)


class ExecuteTrajectory(PlanExecution):
    """Execute a plan."""

    plan_port = "joint_trajectory_msg"
    joint_trajectory_msg = Input(default="{joint_trajectory_msg}", doc="the plan")


class MoveGripperAction(NamedRobot):
    """Open or close the gripper.

    A position above 0.1 closes: the angle of a Robotiq gripper [rad], or the suction. Other
    positions open it, except those below 0.02 of a Franka hand, whose position is an opening [m]:
    the name of its action has one of the words in `METRIC`.
    """

    needs_gripper = True
    METRIC: ClassVar = ("franka", "panda", "left_gripper", "right_gripper")
    memory: ClassVar[tuple[str, ...]] = (*NamedRobot.memory, "_closes")
    _closes = False
    gripper_command_action_name = Input(str, default="", doc="name of the action")
    position = Input(float, doc="position of the gripper")
    timeout = Input(float, default=10.0, doc="timeout", unit="s")

    def start(self) -> None:
        """Start opening or closing."""
        action, position = self.gripper_command_action_name, self.position
        metric = any(word in action for word in self.METRIC)
        self._closes = position > 0.1 or (metric and position < 0.02)
        if self._closes:
            self.gripper.close(self.gripper.default_force())
        else:
            self.gripper.open()

    def update(self) -> Status:
        """Wait until the gripper is open, or closed on an object or on nothing."""
        gripper, arm = self.gripper, self.arm
        self.feedback_message = gripper.status
        if self._closes:
            self.yield_to_force()
            if gripper.steady or gripper.closed_on_nothing:
                for name in self.held_objects()[:1]:
                    arm.payload = payload_of(self.cell, name, self.T_wt)
                return Status.SUCCESS
        elif gripper.is_open:
            arm.payload = None
            return Status.SUCCESS
        if self.timeout > 0.0 and self.elapsed > self.timeout:
            return self.fail(f"{gripper.status}, still after {self.timeout:g} s")
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop the gripper when halted."""
        if new_status == Status.INVALID:
            self.stop_gripper()
