"""Payload of the arm from a held object."""

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import Cell
from bt_manip.robots import Payload


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
