"""Base classes of the leaves of MoveIt Pro."""

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.behaviours import ArmBehaviour
from bt_manip.bt import InOut, Input, Node, Status, SyncAction
from bt_manip.exceptions import BtManipError, MotionError, PortError
from bt_manip_moveit_pro.values import JointState, PoseStamped, expect

PUBLISHED = "{@moveit_pro_frames}"
"""Entry of the frames that PublishTF publishes: PoseStamped by name."""

TOOL = re.compile(r"(.*_)?(tool0|tool_frame|grasp_link|pinch|ee_link|end_effector_link|hand_tcp)")
"""Names of links that mean the tool of the arm."""

BASE = re.compile(r"(.*_)?(base_link|base|link0)")
"""Names of links that mean the base of the arm."""

WORLD = ("", "world", "map", "odom")
"""Names of the frame of the world."""


_NUMBERS = Input(list[float]).type


def _parse_numbers(text: str) -> list[float]:
    assert _NUMBERS.parse is not None
    numbers: list[float] = _NUMBERS.parse(";".join(part.strip() for part in text.split(";")))
    return numbers


NUMBERS = replace(_NUMBERS, parse=_parse_numbers)
"""The type of a port for numbers between ``;``, with spaces around them or not."""


def read_dict(node: Node, port: str) -> dict[str, Any]:
    """Return a copy of the dictionary at a port; an empty one where its entry is missing."""
    try:
        return dict(node.read_port(port))
    except PortError:
        return {}


class UnusedPorts(Node):
    """A node that accepts the ports named in `ignored`, without effect."""

    ignored: ClassVar[str] = ""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Declare the ports."""
        for name in cls.__dict__.get("ignored", "").split():
            port = Input(name=name, default="", doc="no effect here")
            setattr(cls, f"{name}_unused", port)
            port.__set_name__(cls, f"{name}_unused")
        super().__init_subclass__(**kwargs)


class Leaf(UnusedPorts, SyncAction):
    """A leaf that works at once, in `_run`, and that fails with the reason of an error there."""

    def _run(self) -> None:
        """Work."""

    def update(self) -> Status:
        """Work, or fail with the reason."""
        try:
            self._run()
        except (BtManipError, ValueError, OSError) as error:
            return self.fail(str(error))
        return Status.FAILURE if self._node_ended else Status.SUCCESS


class NamedRobot(ArmBehaviour):
    """A leaf of the robot NAME where its group of joints, or its action, is named ``NAME_...``."""

    def choose_robot(self) -> None:
        """Select the robot: that of the port, or the named one."""
        for port in ("planning_group_name", "joint_group_name", "gripper_command_action_name"):
            if port in self.ports and not self.robot:
                group = str(self.read_port(port)).lstrip("/")
                for name in self._robots:
                    if group.startswith(f"{name}_"):
                        self._robot_name = name
                        return
        super().choose_robot()


class RobotLeaf(UnusedPorts, NamedRobot):
    """A leaf that works at once, as `Leaf`, with an arm, and that knows frames by their names."""

    needs_rest = False
    frames = InOut(default=PUBLISHED, doc="frames that PublishTF published")

    def _run(self) -> None:
        """Work."""

    def start(self) -> None:
        """Work, or fail with the reason."""
        try:
            self._run()
        except (BtManipError, ValueError) as error:
            self.fail(str(error))

    def update(self) -> Status:
        """Succeed; `start` has done the work."""
        return Status.SUCCESS

    def frame(self, name: str) -> pin.SE3:
        """Return the pose of a frame in the world.

        It is, in this order: the world; a frame that PublishTF published; an object or robot of the
        cell; the tool of the arm, by the usual names of links; a body of the robot; its base.

        Raises:
            ValueError: If there is no such frame.
        """
        if name in WORLD:
            return pin.SE3.Identity()
        published = read_dict(self, "frames")
        if name in published:
            return self.in_world(published[name])
        if name in self.cell.entities:
            return self.cell.pose(name)
        if TOOL.fullmatch(name):
            return self.T_wt
        model, data = self.cell.model, self.cell.data
        bodies = {model.body(i).name: i for i in range(model.nbody)}
        body = bodies.get(f"{self.robot_name}/{name}")
        if body is None and BASE.fullmatch(name):
            body = int(model.body_parentid[model.dof_bodyid[self.arm.robot.dof_adr[0]]])
        if body is None:
            raise ValueError(f"there is no frame '{name}'")
        return spatial.pose(data.xpos[body], data.xquat[body])

    def in_world(self, pose: object) -> pin.SE3:
        """Return a pose in the world.

        Raises:
            ValueError: If it is no PoseStamped, or its frame is not known.
        """
        stamped = expect(pose, PoseStamped)
        return self.frame(stamped.frame) * stamped.T

    def require_solution(self, T_wt: pin.SE3, q: np.ndarray) -> np.ndarray:
        """Return joint positions that put the tool at a pose, the nearest to others [rad].

        Raises:
            MotionError: If there are none.
        """
        found = self.arm.ik.nearest(T_wt, q)
        if not found.solved:
            raise MotionError(f"the pose is unreachable: {found.reason}", reason="unreachable")
        return np.asarray(found.q)

    def configuration(self, state: object) -> np.ndarray:
        """Return the joint positions of the arm in a joint state [rad].

        Raises:
            ValueError: If it is no joint state of this arm.
        """
        group = ""
        if "planning_group_name" in self.ports:
            group = str(self.read_port("planning_group_name")).partition("_")[0]
        joints = self.arm.robot.description.arm_joints
        return np.array(expect(state, JointState).configuration(joints, self.robot_name, group))

    def state_of(self, q: Iterable[float]) -> JointState:
        """Return joint positions of the arm as a joint state [rad]."""
        joints = self.arm.robot.description.arm_joints
        return JointState(dict(zip(joints, map(float, q), strict=True)))
