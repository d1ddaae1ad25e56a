"""Conditions on objects in the cell and on robots."""

from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input, Status
from bt_manip.bt.nodes import Condition
from bt_manip.cell import Cell, CellError, entity_of, is_rest_velocity, why_not_in, why_not_on

from .poses import pose_input
from .robot_port import RobotCondition


class CellCondition(Condition):
    """A condition on the cell."""

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
    """A condition on an object in the cell.

    Attributes:
        destination: Port with the object's desired location, for goal-conditioned environments;
            empty if the condition does not depend on its position.
    """

    destination: ClassVar[str] = ""

    object = Input(str, doc="Name of the object.")


class ObjectExists(ObjectCondition):
    """Check that the cell has an object of the given name."""

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

    container = Input(str, doc="Name of the container.")

    def why_not(self) -> str:
        """Check that the object is released, at rest, and supported inside the container."""
        return why_not_in(self.cell, self.object, self.container)


class IsOn(ObjectCondition):
    """Check that an object is at rest on another one.

    No robot touches it, and the support carries at least a quarter of its weight.
    """

    destination = "support"

    support = Input(str, doc="Name of the object below it.")

    def why_not(self) -> str:
        """Check that the object is released, at rest, and carried by the support."""
        return why_not_on(self.cell, self.object, self.support)


class IsHolding(RobotCondition):
    """Check that the gripper holds an object, moving or not.

    Two fingers hold what both touch from opposite sides, not what both press on from one side; a
    real gripper holds what it says.
    """

    needs_gripper = True

    object = Input(str, doc="Name of the object.")

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
