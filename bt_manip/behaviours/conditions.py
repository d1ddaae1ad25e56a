"""Conditions on objects in the cell and on robots."""

import contextlib
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input, NodeStatus, Status, Traits
from bt_manip.bt.nodes import Condition
from bt_manip.cell import Cell, CellError, entity_of, is_rest_velocity, why_not_in, why_not_on
from bt_manip.exceptions import PortError

from .destination import Destination
from .object_port import ObjectInput, is_pattern, matching_objects
from .poses import pose_input
from .robot_port import RobotCondition

_FAR = 0.3  # [m] distance of the tool at which the progress has fallen to exp(-1)


class CellCondition(Condition):
    """A condition on the cell.

    For dense rewards it has a method ``places()``, which returns the `Destination` of each object
    by name (None: it belongs nowhere), or ``progress()``, which returns how near it is to hold,
    from 0 to 1.
    """

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell."""
        self.cell: Cell = infrastructure["cell"]

    def why_not(self) -> str:
        """Return why the condition does not hold; empty if it does.

        Raises:
            CellError: If the cell lacks an object.
        """
        raise NotImplementedError

    def update(self) -> Status:
        """Check the cell."""
        try:
            reason = self.why_not()
        except CellError as error:
            reason = str(error)
        return self.fail(reason) if reason else Status.SUCCESS


class ObjectCondition(CellCondition):
    """A condition on an object in the cell, or on each of several.

    A pattern or kind of objects stands for those that the cell has when the tree is set up.

    Attributes:
        destination: Port with the object's desired location, for goal-conditioned environments;
            empty if the condition does not depend on its position.
    """

    destination: ClassVar[str] = ""

    object = ObjectInput(
        str, doc="Name of the object; of several: a pattern, part_*, or a kind, kind:cube."
    )

    _pattern = ""

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell, and find the objects of a pattern.

        Raises:
            CellError: If there is none.
        """
        super().setup(**infrastructure)
        self.goal_conditions = ()
        with contextlib.suppress(PortError):  # the entry is written later
            self._pattern = self.object
            if isinstance(type(self).object, ObjectInput) and is_pattern(self._pattern):
                names = matching_objects([self._pattern], infrastructure)
                self.goal_conditions = [self.with_port("object", name) for name in names]
        for condition in self.goal_conditions:
            condition.setup(**infrastructure)

    def update(self) -> Status:
        """Check the object, or each of several."""
        if not self.goal_conditions or self.object != self._pattern:
            return super().update()
        checks = ((one.update(), one.feedback_message) for one in self.goal_conditions)
        reasons = [reason for status, reason in checks if status is not Status.SUCCESS]
        return self.fail("; ".join(reasons)) if reasons else Status.SUCCESS


class ObjectExists(ObjectCondition):
    """Check that the cell has an object of the given name."""

    object = Input(str, doc="Name of the object.")

    def why_not(self) -> str:
        """Look up the name."""
        return "" if self.object in self.cell.objects else f"the cell has no object '{self.object}'"


class IsIn(ObjectCondition):
    """Check that an object is at rest inside a container.

    It touches only the container and freely moving objects, and is supported from below by the
    inside of the container or another object inside. The container surrounds its lower end up to
    gaps narrower than the object: a place on the container's rim, foot or handle is not inside, nor
    is one in a container that lies on its side. A gripped object is not in the container.
    """

    destination = "container"

    container = ObjectInput(str, doc="Name of the container.")

    def why_not(self) -> str:
        """Check that the object is released, at rest, and supported inside the container."""
        return why_not_in(self.cell, self.object, self.container)

    def places(self) -> Mapping[str, Destination]:
        """Return the inside of the container."""
        return {self.object: Destination.inside(self.cell, self.container)}


class IsOn(ObjectCondition):
    """Check that an object is at rest on another one.

    No robot touches it, and the support carries at least a quarter of its weight.
    """

    destination = "support"

    support = ObjectInput(str, doc="Name of the object below it.")

    def why_not(self) -> str:
        """Check that the object is released, at rest, and carried by the support."""
        return why_not_on(self.cell, self.object, self.support)

    def places(self) -> Mapping[str, Destination]:
        """Return the top of the support."""
        return {self.object: Destination.on(self.cell, self.support)}


class IsHolding(RobotCondition):
    """Check that the gripper holds an object, moving or not.

    Two fingers hold what both touch from opposite sides, not what both press on from one side; a
    real gripper holds what it says.
    """

    needs_gripper = True
    traits = Traits(returns={NodeStatus.SUCCESS, NodeStatus.FAILURE}, leaves={"holding": True})

    object = ObjectInput(str, doc="Name of the object.")

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell, too."""
        super().setup(**infrastructure)
        self.cell: Cell = infrastructure["cell"]

    def update(self) -> Status:
        """Compare the held objects with the given one, and the sides of the fingers' contacts."""
        held = self.gripper.held
        if self.object not in held:
            holds = ", ".join(held) or "nothing"
            return self.fail(f"the gripper holds {holds}, not '{self.object}'")
        points = self.cell.contacts.points(self.object) if len(self.gripper.forces) > 1 else []
        normals = np.array([p.normal for p in points if entity_of(p.other) == self.robot_name])
        if len(normals) and not (normals @ normals.T < 0.0).any():
            return self.fail(f"the fingers press on one side of '{self.object}'")
        return Status.SUCCESS

    def progress(self) -> float:
        """Return how near the tool is to the object."""
        away = self.arm.robot.tool_pose.translation - self.cell.pose(self.object).translation
        return float(np.exp(-np.linalg.norm(away) / _FAR))


class IsAt(RobotCondition):
    """Check that the tool is at rest at a pose."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")
    position_tolerance = Input(float, default=1e-3, doc="Largest distance [m].")
    rotation_tolerance = Input(float, default=1e-2, doc="Largest angle [rad].")

    def update(self) -> Status:
        """Compare the measured tool pose with the given one, and the velocity with rest."""
        T_wt = self.arm.model.pose(self.arm.robot.q)
        error = T_wt.actInv(self.pose)
        distance = float(np.linalg.norm(error.translation))
        angle = float(np.linalg.norm(pin.log3(error.rotation)))
        if distance <= self.position_tolerance and angle <= self.rotation_tolerance:
            if is_rest_velocity(self.arm.robot.tool_velocity):
                return Status.SUCCESS
            return self.fail("the tool moves")
        return self.fail(f"the tool is {1000 * distance:.1f} mm and {angle:.3f} rad away")

    def progress(self) -> float:
        """Return how near the tool is to the pose."""
        away = self.arm.robot.tool_pose.translation - self.pose.translation
        return float(np.exp(-np.linalg.norm(away) / _FAR))
