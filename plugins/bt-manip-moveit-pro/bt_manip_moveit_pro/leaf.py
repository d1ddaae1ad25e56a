"""Base classes of the leaves of MoveIt Pro."""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.behaviours import ArmBehaviour
from bt_manip.bt import InOut, Input, Status, SyncAction
from bt_manip.exceptions import BtManipError, MotionError
from bt_manip_moveit_pro.values import PoseStamped

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
    """Parse numbers between ``;``, with spaces around them."""
    assert _NUMBERS.parse is not None
    numbers: list[float] = _NUMBERS.parse(";".join(part.strip() for part in text.split(";")))
    return numbers


NUMBERS = replace(_NUMBERS, parse=_parse_numbers)
"""The type of a port for numbers between ``;``."""


class Leaf(SyncAction):
    """A leaf that works at once, and that fails with the reason where a port has no such value.

    A subclass implements `run`. The ports in `ignored` are accepted and have no effect.
    """

    ignored: ClassVar[str] = ""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Declare the ports without effect."""
        declare_unused(cls)
        super().__init_subclass__(**kwargs)

    def run(self) -> None:
        """Work.

        Raises:
            ValueError: If a value is wrong.
            BtManipError: If an entry is missing, or something else is wrong.
        """

    def update(self) -> Status:
        """Work, or fail with the reason."""
        try:
            self.run()
        except (BtManipError, ValueError, OSError) as error:
            return self.fail(str(error))
        return Status.FAILURE if self._node_ended else Status.SUCCESS


def declare_unused(cls: Any) -> None:
    """Give a class the ports named in its `ignored`."""
    for name in cls.__dict__.get("ignored", "").split():
        port = Input(name=name, default="", doc="no effect here")
        setattr(cls, f"{name}_unused", port)
        port.__set_name__(cls, f"{name}_unused")


class RobotLeaf(ArmBehaviour):
    """A leaf that works at once with an arm, and that knows frames by their names.

    A subclass implements `run`, as of `Leaf`. In a cell of several robots, a group of joints named
    ``NAME_...`` selects the robot NAME.
    """

    ignored: ClassVar[str] = ""
    needs_rest = False
    frames = InOut(default=PUBLISHED, doc="frames that PublishTF published")

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Declare the ports without effect."""
        declare_unused(cls)
        super().__init_subclass__(**kwargs)

    def choose_robot(self) -> None:
        """Select the robot: that of the port, or that of the group of joints."""
        for port in ("planning_group_name", "joint_group_name"):
            if port in self.ports and len(self._robots) > 1 and not self.robot:
                group = str(self.read_port(port))
                for name in self._robots:
                    if group.startswith(f"{name}_"):
                        self._robot_name = name
                        return
        super().choose_robot()

    def run(self) -> None:
        """Work; see `Leaf.run`."""

    def start(self) -> None:
        """Work, or fail with the reason."""
        try:
            self.run()
        except (BtManipError, ValueError, OSError) as error:
            self.fail(str(error))

    def update(self) -> Status:
        """Succeed; `start` has done the work."""
        return Status.SUCCESS

    # ------------------------------------------------------------------ frames

    def frame(self, name: str) -> pin.SE3:
        """Return the pose of a frame in the world.

        It is, in this order: the world; a frame that PublishTF published; an object or robot of the
        cell; a body of the robot; the tool or the base of the arm, by the usual names of links.

        Raises:
            ValueError: If there is no such frame.
        """
        if name in WORLD:
            return pin.SE3.Identity()
        published = self.published
        if name in published:
            return self.in_world(published[name])
        if name in self.cell.entities:
            return self.cell.pose(name)
        if TOOL.fullmatch(name):
            return self.T_wt
        body = self._body(name)
        if body is None and BASE.fullmatch(name):
            model, robot = self.cell.model, self.arm.robot
            body = int(model.body_parentid[model.dof_bodyid[robot.dof_adr[0]]])
        if body is None:
            raise ValueError(f"there is no frame '{name}'")
        data = self.cell.data
        return spatial.pose(data.xpos[body], data.xquat[body])

    @property
    def published(self) -> Mapping[str, PoseStamped]:
        """Frames that PublishTF published, by name."""
        try:
            found: Mapping[str, PoseStamped] = self.frames
        except BtManipError:
            return {}
        return found

    def _body(self, name: str) -> int | None:
        model = self.cell.model
        ends = [i for i in range(model.nbody) if model.body(i).name == f"{self.robot_name}/{name}"]
        return ends[0] if ends else None

    def in_world(self, pose: PoseStamped) -> pin.SE3:
        """Return a pose in the world.

        Raises:
            ValueError: If its frame is not known.
        """
        if not isinstance(pose, PoseStamped):
            raise ValueError(f"a pose is expected, not {type(pose).__name__}")
        return self.frame(pose.frame) * pose.T

    def require_solution(self, T_wt: pin.SE3, q: np.ndarray) -> np.ndarray:
        """Return joint positions that put the tool at a pose, the nearest to others [rad].

        Raises:
            MotionError: If there are none.
        """
        found = self.arm.ik.nearest(T_wt, q)
        if not found.solved:
            raise MotionError(f"the pose is unreachable: {found.reason}", reason="unreachable")
        return np.asarray(found.q)
