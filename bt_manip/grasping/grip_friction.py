"""Friction needed to hold an object."""

import numpy as np

from bt_manip.cell import Cell
from bt_manip.exceptions import MotionError
from bt_manip.grippers import contact_friction, solids_of
from bt_manip.robots import Gripper


def check_friction(cell: Cell, gripper: Gripper, name: str, force: float | None = None) -> None:
    """Check that friction can carry an object's weight at rest, in any orientation of the hand.

    Mass and friction are those of the simulated model, overrides included. Fixed objects need no
    friction.

    Args:
        cell: The cell with the object.
        gripper: The gripper.
        name: The object.
        force: Grip force [N]; default: the gripper's maximum.

    Raises:
        CellError: If there is no such object.
        GripperError: If the gripper cannot hold with this force.
        MotionError: If the friction is too small.
    """
    model, body = cell.model, cell.body_id(name)
    if model.body_dofnum[body] != 6:
        return
    force = gripper.check_force(gripper.max_force if force is None else force)
    mass = float(model.body_subtreemass[body])
    needed = gripper.required_friction(mass * float(np.linalg.norm(model.opt.gravity)), force)
    friction = contact_friction(solids_of(cell, name)) if needed else 0.0
    if friction < needed:
        raise MotionError(
            f"too little friction to hold '{name}': {mass:.3g} kg needs a friction coefficient of "
            f"at least {needed:.3g} at {len(gripper.forces)} x {force:g} N; '{name}' has "
            f"{friction:.3g}",
            reason="grasp",
        )


def holding_force(cell: Cell, gripper: Gripper, name: str, force: float) -> float:
    """Return the largest tangential force by which friction holds an object [N].

    Infinite if the grip does not depend on friction.

    Args:
        cell: The cell with the object.
        gripper: The gripper; its required friction is assumed to be proportional to the load.
        name: The object.
        force: Grip force [N].
    """
    per_newton = gripper.required_friction(1.0, force)
    return contact_friction(solids_of(cell, name)) / per_newton if per_newton else np.inf
