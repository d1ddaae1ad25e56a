"""Grasps that objects declare, by their class or by sites of their model."""

import mujoco
import numpy as np

from bt_manip import spatial
from bt_manip.cell import Cell, as_object, body_poses
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
    model = cell.model
    found = list(as_object(cell.entities[name]).grasps)
    poses = body_poses(model, cell.body_id(name), cell.data.qpos)
    for site in np.flatnonzero(np.isin(model.site_bodyid, list(poses))):
        if model.site(site).name.rpartition("/")[2].startswith(SITE_PREFIX):
            T_bs = spatial.pose(model.site_pos[site], model.site_quat[site])
            half = model.site_size[site, 1 if model.site_type[site] == _BOX else 0]
            found.append(DeclaredGrasp(poses[int(model.site_bodyid[site])] * T_bs, 2 * float(half)))
    return found
