"""Leaves that make and change poses and other geometric messages."""

import math

import numpy as np
import pinocchio as pin

from bt_manip.bt import InOut, Input, Output
from bt_manip_moveit_pro.leaf import NUMBERS, PUBLISHED, Leaf, RobotLeaf, read_dict
from bt_manip_moveit_pro.values import JointState, PoseStamped, expect, transform


class CreatePoseStamped(Leaf):
    """Make a pose in a frame."""

    reference_frame = Input(str, default="world", doc="name of its frame")
    position_xyz = Input(NUMBERS, default="0;0;0", doc="position [m]")
    orientation_xyzw = Input(NUMBERS, default="0;0;0;1", doc="quaternion")
    pose_stamped = Output(doc="the pose")

    def _run(self) -> None:
        position, orientation = tuple(self.position_xyz), tuple(self.orientation_xyzw)
        transform(position, orientation)  # raises an error if they are no pose
        self.pose_stamped = PoseStamped(self.reference_frame, position, orientation)


class TransformPose(Leaf):
    """Move a pose by a translation and a rotation, along its own axes."""

    ignored = "visualize_pose marker_lifetime marker_size marker_text marker_name"
    input_pose = Input(doc="the pose")
    translation_xyz = Input(NUMBERS, default="0;0;0", doc="translation [m]")
    quaternion_xyzw = Input(NUMBERS, default="0;0;0;1", doc="rotation")
    output_pose = Output(doc="the moved pose")

    def _run(self) -> None:
        pose = expect(self.input_pose, PoseStamped)
        moved = pose.T * transform(self.translation_xyz, self.quaternion_xyzw)
        self.output_pose = PoseStamped.of(pose.frame, moved)


class OverridePoseOrientation(Leaf):
    """Replace the orientation of a pose."""

    input_pose = Input(doc="the pose")
    orientation_xyzw = Input(NUMBERS, default="0;0;0;1", doc="quaternion")
    output_pose = Output(doc="the pose with this orientation")

    def _run(self) -> None:
        pose, orientation = expect(self.input_pose, PoseStamped), tuple(self.orientation_xyzw)
        transform(pose.position, orientation)  # raises an error if it is no orientation
        self.output_pose = PoseStamped(pose.frame, pose.position, orientation)


class IsPoseNearIdentity(Leaf):
    """Succeed where a pose is nearly the origin of its frame."""

    pose = Input(doc="the pose")
    position_tolerance = Input(float, default=0.01, doc="largest distance", unit="m")
    rotation_tolerance = Input(float, default=0.01, doc="largest angle", unit="rad")

    def _run(self) -> None:
        T = expect(self.pose, PoseStamped).T
        distance, angle = np.linalg.norm(T.translation), np.linalg.norm(pin.log3(T.rotation))
        if distance > self.position_tolerance or angle > self.rotation_tolerance:
            self.fail(f"the pose is {distance:.4f} m and {angle:.4f} rad from the origin")


class TransformPoseWithPose(Leaf):
    """Move a pose by the transform that another pose is: in that one's frame."""

    input_pose = Input(doc="the pose")
    transform_pose = Input(doc="the transform")
    output_pose = Output(doc="the moved pose, in the frame of the transform")

    def _run(self) -> None:
        by, pose = expect(self.transform_pose, PoseStamped), expect(self.input_pose, PoseStamped)
        self.output_pose = PoseStamped.of(by.frame, by.T * pose.T)


class TransformPoseFrame(RobotLeaf):
    """Express a pose in another frame."""

    input_pose = Input(doc="the pose")
    target_frame_id = Input(str, doc="name of the frame")
    output_pose = Output(doc="the pose in that frame")

    def _run(self) -> None:
        name = self.target_frame_id
        T = self.frame(name).actInv(self.in_world(self.input_pose))
        self.output_pose = PoseStamped.of(name, T)


class CalculatePoseOffset(RobotLeaf):
    """Express a pose relative to another one."""

    source_pose = Input(doc="the pose that becomes the origin")
    destination_pose = Input(doc="the other pose")
    source_to_destination_pose = Output(doc="the other pose, seen from the first")

    def _run(self) -> None:
        source = expect(self.source_pose, PoseStamped)
        T = self.in_world(source).actInv(self.in_world(self.destination_pose))
        self.source_to_destination_pose = PoseStamped.of(source.frame, T)


class AveragePoseStampedVector(Leaf):
    """Average poses of one frame: their positions, and their orientations as quaternions."""

    pose_stamped_vector = Input(doc="poses")
    average_pose_stamped = Output(doc="their average")

    def _run(self) -> None:
        poses = [expect(pose, PoseStamped) for pose in self.pose_stamped_vector]
        if not poses or len({pose.frame for pose in poses}) > 1:
            raise ValueError("poses of one frame are averaged, at least one")
        # The principal eigenvector is the average (Markley et al. 2007), whatever their signs.
        quaternions = np.array([pose.orientation for pose in poses])
        _, vectors = np.linalg.eigh(quaternions.T @ quaternions)
        position = np.mean([pose.position for pose in poses], axis=0)
        self.average_pose_stamped = PoseStamped(
            poses[0].frame, tuple(position.tolist()), tuple(vectors[:, -1].tolist())
        )


class PublishTF(Leaf):
    """Give a pose a name, as a frame."""

    ignored = "publish_rate"
    pose = Input(doc="the pose")
    child_frame_id = Input(str, doc="name of the frame")
    frames = InOut(default=PUBLISHED, doc="frames that were published")

    def _run(self) -> None:
        pose, name = expect(self.pose, PoseStamped), self.child_frame_id
        frames = {**read_dict(self, "frames"), name: pose}
        frame = pose.frame
        while frame in frames:
            if frame == name:
                raise ValueError(f"the pose of '{name}' is in its own frame")
            frame = frames[frame].frame
        self.frames = frames


class ComputeLinkPoseForwardKinematics(RobotLeaf):
    """Compute the pose of the tool at joint positions."""

    ignored = "link_name planning_scene"
    joint_state = Input(doc="joint positions")
    link_pose = Output(doc="its pose in the world")

    def _run(self) -> None:
        T = self.arm.model.pose(self.configuration(self.joint_state))
        self.link_pose = PoseStamped.of("world", T)


class GenerateCoveragePath(Leaf):
    """Make a path in lanes over a rectangle, from its corner along the corner's x and y axes.

    The lanes are parallel to y, `width` long; they cover `height` along x.
    """

    bottom_right_corner = Input(doc="pose of the corner")
    width = Input(float, doc="extent along y", unit="m")
    height = Input(float, doc="extent along x", unit="m")
    stride_distance = Input(float, doc="distance of the lanes", unit="m", above=0.0)
    vector_of_poses = Output(doc="poses with the orientation of the corner")

    def _run(self) -> None:
        corner, width = expect(self.bottom_right_corner, PoseStamped), self.width
        lanes = math.floor(self.height / self.stride_distance + 1e-9) + 1
        poses = []
        for lane in range(lanes):
            ends = (0.0, width) if lane % 2 == 0 else (width, 0.0)
            for y in ends:
                shift = transform((lane * self.stride_distance, y, 0.0), (0.0, 0.0, 0.0, 1.0))
                poses.append(PoseStamped.of(corner.frame, corner.T * shift))
        self.vector_of_poses = poses


class UnpackPoseMessage(Leaf):
    """Take a pose apart."""

    pose = Input(doc="the pose")
    position = Output(doc="its position [m]")
    orientation = Output(doc="its quaternion x, y, z, w")

    def _run(self) -> None:
        pose = expect(self.pose, PoseStamped)
        self.position, self.orientation = list(pose.position), list(pose.orientation)


class UnpackPointMessage(Leaf):
    """Take a point apart."""

    point = Input(NUMBERS, doc="the point")
    x = Output(float, doc="x [m]")
    y = Output(float, doc="y [m]")
    z = Output(float, doc="z [m]")

    def _run(self) -> None:
        self.x, self.y, self.z = self.point


class UnpackJointStateMessage(Leaf):
    """Take a joint state apart."""

    ignored = "header velocity effort"
    joint_state = Input(doc="the joint state")
    names = Output(name="name_", doc="names of the joints")
    position = Output(doc="their positions [rad]")

    def _run(self) -> None:
        positions = expect(self.joint_state, JointState).positions
        self.names, self.position = list(positions), list(positions.values())


class UnpackRobotStateMessage(Leaf):
    """Take a robot state apart: here it is its joint state."""

    ignored = "multi_dof_joint_state"
    robot_state = Input(doc="the robot state")
    joint_state = Output(doc="its joint state")

    def _run(self) -> None:
        self.joint_state = self.robot_state


class CreateRobotState(Leaf):
    """Make a joint state."""

    ignored = "velocities"
    joint_names = Input(list[str], doc="names of the joints")
    joint_positions = Input(NUMBERS, name="positions", doc="their positions [rad]")
    joint_state_msg = Output(doc="the joint state")

    def _run(self) -> None:
        names, positions = self.joint_names, self.joint_positions
        if len(names) != len(positions):
            raise ValueError(f"{len(names)} joints and {len(positions)} positions")
        self.joint_state_msg = JointState(dict(zip(names, positions, strict=True)))
