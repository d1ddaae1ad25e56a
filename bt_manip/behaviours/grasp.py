"""Grasp an object; the payload that it becomes."""

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.bt import Input, Status
from bt_manip.cell import Cell
from bt_manip.grasping import check_friction
from bt_manip.robots import GRIP_FORCE, Gripper, Payload

from .arm_behaviour import GripperBehaviour
from .automatic import number_or_auto


def payload_of(cell: Cell, name: str, T_wt: pin.SE3) -> Payload:
    """Return an object's mass, centre of mass and inertia in the frame of the tool that holds it.

    Args:
        cell: The cell that the object is in.
        name: The object's name.
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


def default_force(gripper: Gripper, preferred: float = GRIP_FORCE) -> float:
    """Return the force to grip with where none is given [N].

    Args:
        gripper: The gripper.
        preferred: Force of grippers that are strong enough [N].
    """
    return gripper.default_force(preferred)


def preferred_force_input() -> Input:
    """Declare the port of the force that ``auto`` takes."""
    return Input(
        float, default=GRIP_FORCE, doc="Gripping force that auto takes if the gripper has it [N]."
    )


class Grasp(GripperBehaviour):
    """Close the gripper on an object until the grip is steady.

    The grip is steady when its force has stayed near the commanded one for a while; the impact of
    closing exceeds any force for milliseconds. The object then becomes the arm's payload.

    An arm on which an external force acts meanwhile yields to it until the next motion: a jaw that
    turns presses the object on its support, and pushes the arm aside.
    """

    object = Input(str, doc="Name of the object.")
    force = number_or_auto(
        "Gripping force at each contact [N]; auto: the preferred one, or 0.8 of the gripper's "
        "maximum if that is lower."
    )
    preferred_force = preferred_force_input()
    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].")

    memory = (*GripperBehaviour.memory, "_force")

    _force = 0.0  # [N] commanded

    def start(self) -> None:
        """Start to close."""
        self.cell.find(self.object)
        gripper, given = self.gripper, self.force
        self._force = default_force(gripper, self.preferred_force) if given is None else given
        check_friction(self.cell, gripper, self.object, self._force)
        gripper.close(self._force)

    def update(self) -> Status:
        """Wait for a steady grip; yield to the forces of closing."""
        self.yield_to_force()
        self.feedback_message = self.gripper.status
        if self.gripper.steady:
            return self._held()
        if self.gripper.closed_on_nothing:
            return self.fail(f"the gripper closed without gripping '{self.object}'")
        if self.elapsed > self.patience:
            return self.fail(
                f"no steady grip after {self.patience:g} s: {self.gripper.status}, "
                f"commanded {self._force:g} N"
            )
        return Status.RUNNING

    def _held(self) -> Status:
        held = self.gripper.held
        if self.object not in held:
            return self.fail(
                f"the gripper holds {', '.join(held) or 'nothing'}, not '{self.object}'"
            )
        self.arm.payload = payload_of(self.cell, self.object, self.T_wt)
        return Status.SUCCESS
