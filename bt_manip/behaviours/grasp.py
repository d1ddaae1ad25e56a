"""Grasping of an object, which becomes the payload."""

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.bt import Status, Traits
from bt_manip.cell import Cell
from bt_manip.grasping import check_friction
from bt_manip.robots import Payload

from .object_port import ObjectInput
from .open_and_close import CloseGripper


def payload_of(cell: Cell, name: str, T_wt: pin.SE3) -> Payload:
    """Return an object's mass, centre of mass and inertia in the tool frame.

    Args:
        cell: The cell with the object.
        name: Name of the object.
        T_wt: Pose of the tool in the world.
    """
    model = cell.nominal_model  # without randomization
    root = cell.body_id(name)
    T_wo = cell.pose(name)
    total = pin.Inertia.Zero()
    for body in range(root, model.nbody):
        if model.body_rootid[body] != model.body_rootid[root]:
            continue
        T_wb = spatial.pose(cell.data.xpos[body], cell.data.xquat[body])
        T_bi = spatial.pose(model.body_ipos[body], model.body_iquat[body])
        principal = pin.Inertia(
            float(model.body_mass[body]), np.zeros(3), np.diag(model.body_inertia[body])
        )
        total += (T_wo.actInv(T_wb) * T_bi).act(principal)
    in_tool = T_wt.actInv(T_wo).act(total)
    return Payload(in_tool.mass, in_tool.lever, in_tool.inertia)


class Grasp(CloseGripper):
    """Close the gripper on an object until the grip is steady.

    The grip is steady when its force has been near the commanded force for a while, since the
    impact of closing exceeds it for milliseconds. The object then becomes the arm's payload.

    If an external force acts on the arm meanwhile, the arm is compliant until the next motion: a
    pivoting jaw presses the object on its support, and pushes the arm aside.
    """

    traits = Traits(
        commands={"gripper"}, needs={"at_object"}, leaves={"open": False, "holding": True}
    )

    object = ObjectInput(str, doc="Name of the object.")

    def choose_force(self) -> float:
        """Return the grip force at which friction holds the object [N]."""
        self.cell.find(self.object)
        force = super().choose_force()
        check_friction(self.cell, self.gripper, self.object, force)
        return force

    def closed(self) -> Status:
        """Set the object as payload if the gripper holds it."""
        if not self.gripper.steady:
            return self.fail(f"the gripper closed without gripping '{self.object}'")
        held = self.gripper.held
        if self.object not in held:
            return self.fail(
                f"the gripper holds {', '.join(held) or 'nothing'}, not '{self.object}'"
            )
        self.arm.payload = payload_of(self.cell, self.object, self.T_wt)
        return Status.SUCCESS
