"""Grasps that objects declare, by their class or by sites of their model."""

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell, as_object
from bt_manip.cell.objects import DeclaredGrasp

SITE_PREFIX = "grasp"
"""Beginning of the names of sites that are grasps."""

_BOX = int(mujoco.mjtGeom.mjGEOM_BOX)


def declared_grasps(cell: Cell, name: str) -> list[DeclaredGrasp]:
    """Return the grasps that an object declares, those of its class first.

    Args:
        cell: The cell.
        name: Name of the object.
    """
    model, data, T_wo = cell.model, cell.data, cell.pose(name)
    found = list(as_object(cell.entities[name]).grasps)
    root = model.body_rootid[cell.body_id(name)]
    for site in np.flatnonzero(model.body_rootid[model.site_bodyid] == root):
        path = model.site(site).name.split("/")
        if path[0] == name and path[-1].startswith(SITE_PREFIX):
            T_ws = pin.SE3(data.site_xmat[site].reshape(3, 3), data.site_xpos[site])
            half = model.site_size[site, 1 if model.site_type[site] == _BOX else 0]
            found.append(DeclaredGrasp(T_wo.actInv(T_ws), 2.0 * float(half)))
    return found
