"""Leaves that make and change poses and other geometric messages."""

import math

import numpy as np
import pinocchio as pin

from bt_manip.bt import InOut, Input, Output
from bt_manip.exceptions import BtManipError
from bt_manip_moveit_pro.leaf import NUMBERS, PUBLISHED, Leaf, RobotLeaf
from bt_manip_moveit_pro.values import JointState, PoseStamped, transform


def pose_of(value: object) -> PoseStamped:
    """Return a pose.

    Raises:
        ValueError: If it is none.
    """
    if not isinstance(value, PoseStamped):
        raise ValueError(f"a pose is expected, not {type(value).__name__}")
    return value


class CreatePoseStamped(Leaf):
    """Make a pose in a frame."""

    reference_frame = Input(str, default="world", doc="name of its frame")
    position_xyz = Input(NUMBERS, default="0;0;0", doc="position [m]")
    orientation_xyzw = Input(NUMBERS, default="0;0;0;1", doc="quaternion")
    pose_stamped = Output(doc="the pose")

    def run(self) -> None:
        """Write the pose."""
        position, orientation = tuple(self.position_xyz), tuple(self.orientation_xyzw)
        transform(position, orientation)
        self.pose_stamped = PoseStamped(self.reference_frame, position, orientation)


class TransformPose(Leaf):
    """Move a pose by a translation and a rotation, along its own axes."""

    ignored = "visualize_pose marker_lifetime marker_size marker_text marker_name"
    input_pose = Input(doc="the pose")
    translation_xyz = Input(NUMBERS, default="0;0;0", doc="translation [m]")
    quaternion_xyzw = Input(NUMBERS, default="0;0;0;1", doc="rotation")
    output_pose = Output(doc="the moved pose")

    def run(self) -> None:
        """Write the moved pose."""
        pose = pose_of(self.input_pose)
        moved = pose.T * transform(self.translation_xyz, self.quaternion_xyzw)
        self.output_pose = PoseStamped.of(pose.frame, moved)


class TransformPoseWithPose(Leaf):
    """Move a pose by the transform that another pose is: in that one's frame."""

    input_pose = Input(doc="the pose")
    transform_pose = Input(doc="the transform")
    output_pose = Output(doc="the moved pose, in the frame of the transform")

    def run(self) -> None:
        """Write the moved pose."""
        by = pose_of(self.transform_pose)
        self.output_pose = PoseStamped.of(by.frame, by.T * pose_of(self.input_pose).T)


class TransformPoseFrame(RobotLeaf):
    """Express a pose in another frame."""

    input_pose = Input(doc="the pose")
    target_frame_id = Input(str, doc="name of the frame")
    output_pose = Output(doc="the pose in that frame")

    def run(self) -> None:
        """Write the pose."""
        name = self.target_frame_id
        T = self.frame(name).actInv(self.in_world(pose_of(self.input_pose)))
        self.output_pose = PoseStamped.of(name, T)


class OverridePoseOrientation(Leaf):
    """Replace the orientation of a pose."""

    input_pose = Input(doc="the pose")
    orientation_xyzw = Input(NUMBERS, default="0;0;0;1", doc="quaternion")
    output_pose = Output(doc="the pose with this orientation")

    def run(self) -> None:
        """Write the pose."""
        pose = pose_of(self.input_pose)
        self.output_pose = PoseStamped(pose.frame, pose.position, tuple(self.orientation_xyzw))


class CalculatePoseOffset(RobotLeaf):
    """Express a pose relative to another one."""

    source_pose = Input(doc="the pose that becomes the origin")
    destination_pose = Input(doc="the other pose")
    source_to_destination_pose = Output(doc="the other pose, seen from the first")

    def run(self) -> None:
        """Write the relative pose."""
        source = pose_of(self.source_pose)
        T = self.in_world(source).actInv(self.in_world(pose_of(self.destination_pose)))
        self.source_to_destination_pose = PoseStamped.of(source.frame, T)


class AveragePoseStampedVector(Leaf):
    """Average poses of one frame: their positions, and their orientations as quaternions."""

    pose_stamped_vector = Input(doc="poses")
    average_pose_stamped = Output(doc="their average")

    def run(self) -> None:
        """Write the average."""
        poses = [pose_of(pose) for pose in self.pose_stamped_vector]
        if not poses or len({pose.frame for pose in poses}) > 1:
            raise ValueError("poses of one frame are averaged, at least one")
        # The principal eigenvector is the average (Markley et al. 2007), whatever their signs.
        quaternions = np.array([pose.orientation for pose in poses])
        _, vectors = np.linalg.eigh(quaternions.T @ quaternions)
        position = np.mean([pose.position for pose in poses], axis=0)
        self.average_pose_stamped = PoseStamped(
            poses[0].frame, tuple(position.tolist()), tuple(vectors[:, -1].tolist())
        )


class IsPoseNearIdentity(Leaf):
    """Succeed where a pose is nearly the origin of its frame."""

    pose = Input(doc="the pose")
    position_tolerance = Input(float, default=0.01, doc="largest distance", unit="m")
    rotation_tolerance = Input(float, default=0.01, doc="largest angle", unit="rad")

    def run(self) -> None:
        """Compare."""
        T = pose_of(self.pose).T
        distance, angle = np.linalg.norm(T.translation), np.linalg.norm(pin.log3(T.rotation))
        if distance > self.position_tolerance or angle > self.rotation_tolerance:
            raise ValueError(f"the pose is {distance:.4f} m and {angle:.4f} rad from the origin")


class UnpackPoseMessage(Leaf):
    """Take a pose apart."""

    pose = Input(doc="the pose")
    position = Output(doc="its position")
    orientation = Output(doc="its quaternion x, y, z, w")

    def run(self) -> None:
        """Write the parts."""
        pose = pose_of(self.pose)
        self.position, self.orientation = list(pose.position), list(pose.orientation)


class UnpackPointMessage(Leaf):
    """Take a point apart."""

    point = Input(NUMBERS, doc="the point")
    x = Output(float, doc="x [m]")
    y = Output(float, doc="y [m]")
    z = Output(float, doc="z [m]")

    def run(self) -> None:
        """Write the coordinates."""
        self.x, self.y, self.z = self.point


class CreateTwistStamped(Leaf):
    """Make a velocity in a frame."""

    reference_frame = Input(str, default="world", doc="name of its frame")
    linear_velocity_xyz = Input(NUMBERS, default="0;0;0", doc="linear velocity [m/s]")
    angular_velocity_xyz = Input(NUMBERS, default="0;0;0", doc="angular velocity [rad/s]")
    twist_stamped = Output(doc="the velocity")

    def run(self) -> None:
        """Write it."""
        self.twist_stamped = {
            "header": {"frame_id": self.reference_frame},
            "twist": {"linear": self.linear_velocity_xyz, "angular": self.angular_velocity_xyz},
        }


class CreateWrenchStamped(Leaf):
    """Make a force and a torque in a frame."""

    reference_frame = Input(str, default="world", doc="name of its frame")
    force_xyz = Input(NUMBERS, default="0;0;0", doc="force [N]")
    torque_xyz = Input(NUMBERS, default="0;0;0", doc="torque [N m]")
    wrench_stamped = Output(doc="force and torque")

    def run(self) -> None:
        """Write it."""
        self.wrench_stamped = {
            "header": {"frame_id": self.reference_frame},
            "wrench": {"force": self.force_xyz, "torque": self.torque_xyz},
        }


class UnpackTwistStampedMessage(Leaf):
    """Take a velocity in a frame apart."""

    twist_stamped = Input(doc="the velocity")
    header = Output(doc="its frame")
    twist = Output(doc="linear and angular velocity")

    def run(self) -> None:
        """Write the parts."""
        message = self.twist_stamped
        self.header, self.twist = message["header"], message["twist"]


class UnpackWrenchStampedMessage(Leaf):
    """Take a force and torque in a frame apart."""

    wrench_stamped = Input(doc="force and torque")
    header = Output(doc="their frame")
    wrench = Output(doc="force and torque")

    def run(self) -> None:
        """Write the parts."""
        message = self.wrench_stamped
        self.header, self.wrench = message["header"], message["wrench"]


class PublishTF(Leaf):
    """Give a pose a name, as a frame."""

    ignored = "publish_rate"
    pose = Input(doc="the pose")
    child_frame_id = Input(str, doc="name of the frame")
    frames = InOut(default=PUBLISHED, doc="frames that were published")

    def run(self) -> None:
        """Publish the frame."""
        pose, name = pose_of(self.pose), self.child_frame_id
        try:
            known = self.frames
        except BtManipError:
            known = {}
        if pose.frame == name:
            raise ValueError(f"the pose of '{name}' is in its own frame")
        self.frames = {**known, name: pose}


class ComputeLinkPoseForwardKinematics(RobotLeaf):
    """Compute the pose of the tool at joint positions."""

    ignored = "planning_scene"
    joint_state = Input(doc="joint positions")
    link_name = Input(str, default="grasp_link", doc="name of the link: the tool")
    link_pose = Output(doc="its pose in the world")

    def run(self) -> None:
        """Write the pose."""
        T = self.arm.model.pose(configuration(self, self.joint_state))
        self.link_pose = PoseStamped.of("world", T)


def configuration(leaf: RobotLeaf, state: object) -> np.ndarray:
    """Return the joint positions of the arm in a joint state [rad].

    Raises:
        ValueError: If it is no joint state of this arm.
    """
    if not isinstance(state, JointState):
        raise ValueError(f"a joint state is expected, not {type(state).__name__}")
    joints = leaf.arm.robot.description.arm_joints
    group = (
        str(leaf.read_port("planning_group_name")) if "planning_group_name" in leaf.ports else ""
    )
    return np.array(state.configuration(joints, leaf.robot_name, group.partition("_")[0]))


class GenerateCoveragePath(Leaf):
    """Make a path in lanes over a rectangle, from its corner along the corner's x and y axes.

    The lanes are parallel to y, `width` long; they cover `height` along x.
    """

    bottom_right_corner = Input(doc="pose of the corner")
    width = Input(float, doc="extent along y", unit="m")
    height = Input(float, doc="extent along x", unit="m")
    stride_distance = Input(float, doc="distance of the lanes", unit="m", above=0.0)
    vector_of_poses = Output(doc="poses with the orientation of the corner")

    def run(self) -> None:
        """Write the poses."""
        corner, width = pose_of(self.bottom_right_corner), self.width
        lanes = math.floor(self.height / self.stride_distance + 1e-9) + 1
        poses = []
        for lane in range(lanes):
            ends = (0.0, width) if lane % 2 == 0 else (width, 0.0)
            for y in ends:
                shift = transform((lane * self.stride_distance, y, 0.0), (0.0, 0.0, 0.0, 1.0))
                poses.append(PoseStamped.of(corner.frame, corner.T * shift))
        self.vector_of_poses = poses


class UnpackRobotStateMessage(Leaf):
    """Take a robot state apart: here it is its joint state."""

    ignored = "multi_dof_joint_state"
    robot_state = Input(doc="the robot state")
    joint_state = Output(doc="its joint state")

    def run(self) -> None:
        """Write the joint state."""
        self.joint_state = self.robot_state


class UnpackJointStateMessage(Leaf):
    """Take a joint state apart."""

    ignored = "header velocity effort"
    joint_state = Input(doc="the joint state")
    names = Output(name="name_", doc="names of the joints")
    position = Output(doc="their positions [rad]")

    def run(self) -> None:
        """Write names and positions."""
        state = self.joint_state
        if not isinstance(state, JointState):
            raise ValueError(f"a joint state is expected, not {type(state).__name__}")
        self.names, self.position = list(state.positions), list(state.positions.values())


class CreateRobotState(Leaf):
    """Make a joint state."""

    ignored = "velocities"
    joint_names = Input(list[str], doc="names of the joints")
    joint_positions = Input(NUMBERS, name="positions", doc="their positions [rad]")
    joint_state_msg = Output(doc="the joint state")

    def run(self) -> None:
        """Write the joint state."""
        names, positions = self.joint_names, self.joint_positions
        if len(names) != len(positions):
            raise ValueError(f"{len(names)} joints and {len(positions)} positions")
        self.joint_state_msg = JointState(dict(zip(names, positions, strict=True)))
