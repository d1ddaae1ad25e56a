"""Leaves that plan and execute motions of the arm and the gripper.

A plan is a list of motions of our own. Leaves that plan check that its poses can be reached; paths
around obstacles are found where the plan is executed.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import ArmBehaviour, MotionBehaviour, payload_of
from bt_manip.bt import Input, Output, Status
from bt_manip.exceptions import MotionError
from bt_manip.planning import LineTo, Planner
from bt_manip.registry import Registry
from bt_manip_moveit_pro.leaf import NUMBERS, RobotLeaf, declare_unused
from bt_manip_moveit_pro.poses import configuration, pose_of
from bt_manip_moveit_pro.values import (
    JointState,
    Motion,
    Plan,
    PoseStamped,
    texts,
    transforms,
)

JOINT_STEP = 0.2  # [rad] of a joint between two checked poses of a path
LINE_STEP = 0.02  # [m], and half of it in units of 10 rad, between them


def plan_of(value: object) -> Plan:
    """Return a plan.

    Raises:
        ValueError: If it is none.
    """
    if not isinstance(value, Plan):
        raise ValueError(f"a trajectory or solution is expected, not {type(value).__name__}")
    return value


class RetrieveWaypoint(RobotLeaf):
    """Get the joint positions of a named configuration."""

    waypoint_name = Input(str, doc="its name")
    joint_group_name = Input(str, default="manipulator", doc="group of joints")
    waypoint_joint_state = Output(doc="its joint state")

    def run(self) -> None:
        """Write the joint state."""
        robot, name = self.arm.robot, self.waypoint_name
        found = robot.configurations.get(name)
        if not isinstance(found, Mapping):
            joints = robot.description.arm_joints
            found = dict(zip(joints, robot.configuration(name), strict=True))
        self.waypoint_joint_state = JointState(dict(found))


class GetJointState(RobotLeaf):
    """Get the measured joint positions of the arm."""

    ignored = "planning_scene"
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    joint_state = Output(doc="the joint state")

    def run(self) -> None:
        """Write the joint state."""
        robot = self.arm.robot
        found = zip(robot.description.arm_joints, map(float, robot.q), strict=True)
        self.joint_state = JointState(dict(found))


class SaveCurrentState(RobotLeaf):
    """Get the measured joint positions of the arm."""

    saved_robot_state = Output(doc="the joint state")

    def run(self) -> None:
        """Write the joint state."""
        robot = self.arm.robot
        found = zip(robot.description.arm_joints, map(float, robot.q), strict=True)
        self.saved_robot_state = JointState(dict(found))


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

    def run(self) -> None:
        """Write the plan."""
        q = configuration(self, self.joint_goal)
        self.arm.model.limits.checked(q, self.arm.model.units)
        speed = min(self.velocity_scale_factor, 1.0)
        self.joint_trajectory_msg = Plan((Motion(q=tuple(q.tolist()), speed=speed),))


class GeneratePointToPointTrajectory(RobotLeaf):
    """Plan a motion to joint positions."""

    ignored = (
        "acceleration_scale_factor jerk_scale_factor start_state start_time "
        "trajectory_sampling_rate"
    )
    target_state = Input(doc="joint state of the goal")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    velocity_scale_factor = Input(float, default=1.0, doc="fraction of the limits", above=0.0)
    joint_trajectory_msg = Output(default="{joint_trajectory_msg}", doc="the plan")

    def run(self) -> None:
        """Write the plan."""
        q = configuration(self, self.target_state)
        speed = min(self.velocity_scale_factor, 1.0)
        self.joint_trajectory_msg = Plan((Motion(q=tuple(q.tolist()), speed=speed),))


class ComputeInverseKinematics(RobotLeaf):
    """Find joint positions that put the tool at a pose."""

    ignored = "ik_timeout_s link_padding planning_scene_msg"
    target_poses = Input(doc="the pose, in a list")
    tip_links = Input(str, default="grasp_link", doc="name of the link: the tool")
    planning_group_name = Input(str, default="manipulator", doc="group of joints")
    solution = Output(doc="the joint state")

    def run(self) -> None:
        """Write the joint state."""
        refuse_several(self.tip_links)
        (pose,) = self.target_poses
        q = self.require_solution(self.in_world(pose_of(pose)), self.arm.robot.q)
        joints = self.arm.robot.description.arm_joints
        self.solution = JointState(dict(zip(joints, q.tolist(), strict=True)))


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

    def run(self) -> None:
        """Write the plan."""
        refuse_several(self.tip_links)
        poses = [pose_of(pose) for pose in self.path_]
        speed = min(self.velocity_scale_factor, 1.0)
        targets = self.targets(poses, self.tip_offset, self.position_only)
        plan = Plan(self.motions(targets, self.blending_radius, speed))
        self.joint_trajectory_msg = self.debug_solution = plan

    def targets(
        self, path: Sequence[PoseStamped], offset: Sequence[float], position_only: bool
    ) -> list[pin.SE3]:
        """Return poses of the tool in the world.

        Raises:
            ValueError: If there are none, or a frame is not known.
        """
        if not path:
            raise ValueError("the path has no poses")
        T_to = pin.SE3(pin.rpy.rpyToMatrix(*offset[3:]), np.array(offset[:3]))
        targets = [self.in_world(pose) * T_to.inverse() for pose in path]
        if position_only:
            rotation = self.T_wt.rotation
            targets = [pin.SE3(rotation, T.translation) for T in targets]
        return targets

    def motions(self, targets: list[pin.SE3], blend: float, speed: float) -> tuple[Motion, ...]:
        """Return the motions through poses of the tool.

        Raises:
            MotionError: If a pose cannot be reached, or the path cannot be followed.
        """
        arm = self.arm
        if len(targets) == 1:
            self.require_solution(targets[0], arm.robot.q)
            return (Motion(path=texts(targets), speed=speed),)
        solutions = arm.ik.solutions(targets[0], arm.robot.q)
        if not solutions:
            self.require_solution(targets[0], arm.robot.q)
        followed = [(self.followed(targets, found.q), found.q) for found in solutions]
        for share, q in followed:
            if share == 1.0:
                start = Motion(q=tuple(q.tolist()))
                return start, Motion(path=texts(targets[1:]), blend=blend, speed=speed)
        most = max((share for share, _ in followed), default=0.0)
        raise MotionError(
            f"the path can be followed up to {100 * most:.0f} %", reason="unreachable"
        )

    def followed(self, targets: Sequence[pin.SE3], q: np.ndarray) -> float:
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

    def run(self) -> None:
        """Check that there is a plan."""
        self.debug_solution = plan_of(self.joint_trajectory_msg)


class PlanExecution(MotionBehaviour):
    """Execute the motions of a plan, one after the other."""

    ignored: ClassVar[str] = ""
    plan_port: ClassVar[str] = ""
    memory: ClassVar[tuple[str, ...]] = (*MotionBehaviour.memory, "_plan", "_next")
    _plan: tuple[Motion, ...] = ()
    _next = 0

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Declare the ports without effect."""
        declare_unused(cls)
        super().__init_subclass__(**kwargs)

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell, the robots and the random generator."""
        super().setup(**infrastructure)
        self._rng = infrastructure["rng"]
        self._planners: Registry[Planner] = infrastructure["planners"]

    def initialise(self) -> None:
        """Begin with the first motion."""
        self._next = 0
        self._plan = ()
        try:
            self._plan = plan_of(self.read_port(self.plan_port)).motions
        except ValueError as error:
            self.fail(str(error))
            return
        super().initialise()

    def start(self) -> None:
        """Start the present motion."""
        if self._next >= len(self._plan):
            return
        motion, arm = self._plan[self._next], self.arm
        if motion.q:
            arm.move_to_configuration(motion.q, speed=motion.speed, rng=self._rng)
        elif motion.poses:
            poses = transforms(motion.poses)
            arm.move_to_pose(poses, motion.speed, approach=motion.approach, rng=self._rng)
        else:
            steps = [LineTo(T) for T in transforms(motion.path)]
            arm.move_path(steps, motion.speed, blend=motion.blend)

    def arrived(self) -> Status:
        """Start the next motion, or succeed after the last one."""
        self._next += 1
        if self._next >= len(self._plan):
            return super().arrived()
        self.begin_motion(self.start)
        return Status.FAILURE if self._node_ended else Status.RUNNING


class ExecuteTrajectory(PlanExecution):
    """Execute a plan."""

    plan_port = "joint_trajectory_msg"
    ignored = (
        "controller_action_name execution_pipeline goal_duration_tolerance "
        "goal_position_tolerance path_position_tolerance absolute_force_torque_threshold "
        "admittance_parameters_msg"
    )
    joint_trajectory_msg = Input(default="{joint_trajectory_msg}", doc="the plan")


class MoveGripperAction(ArmBehaviour):
    """Open or close the gripper.

    A position above 0.1 closes: the angle of a Robotiq gripper [rad], or the suction. Other
    positions open it, except those below 0.02 of a Franka hand, whose position is an opening [m]:
    the name of its action has one of the words in `METRIC`.
    """

    needs_gripper = True
    METRIC: ClassVar = ("franka", "panda", "left_gripper", "right_gripper")
    memory: ClassVar[tuple[str, ...]] = (*ArmBehaviour.memory, "_closes")
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

    def choose_robot(self) -> None:
        """Select the robot: that of the port, or that in the name of the action."""
        action = self.gripper_command_action_name.lstrip("/")
        named = [name for name in self._robots if action.startswith(f"{name}_")]
        if named and not self.robot:
            self._robot_name = named[0]
        else:
            super().choose_robot()

    def update(self) -> Status:
        """Wait until the gripper is open, or closed on an object or on nothing."""
        gripper, arm = self.gripper, self.arm
        if self._closes:
            self.yield_to_force()
        self.feedback_message = gripper.status
        if not self._closes and gripper.is_open:
            arm.payload = None
            return Status.SUCCESS
        if self._closes and (gripper.steady or gripper.closed_on_nothing):
            for name in self.held_objects()[:1]:
                arm.payload = payload_of(self.cell, name, self.T_wt)
            return Status.SUCCESS
        if self.timeout > 0.0 and self.elapsed > self.timeout:
            return self.fail(f"{gripper.status}, still after {self.timeout:g} s")
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop the gripper when halted."""
        if new_status == Status.INVALID:
            self.stop_gripper()
