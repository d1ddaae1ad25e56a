"""Bounding boxes of entities, and distances between them."""

from typing import TYPE_CHECKING

import mujoco
import numpy as np
import pinocchio as pin

from .exceptions import CellError

if TYPE_CHECKING:
    from .cell import Cell


def extent(cell: "Cell", name: str, T_wf: pin.SE3 | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounding box of an entity's collision geometry, along the axes of a frame [m].

    Args:
        cell: The cell.
        name: The entity; geoms without collisions are left out.
        T_wf: The frame; default: the world.

    Returns:
        Its lower and its upper corner.  # 2 x (3,)

    Raises:
        CellError: When there is no such entity, or it has no collision geometry.
    """
    model, data = cell.model, cell.data
    geoms = collision_geoms(cell, name)
    if not len(geoms):
        raise CellError(f"'{name}' has no collision geometry")
    R = data.geom_xmat[geoms].reshape(-1, 3, 3)
    p = data.geom_xpos[geoms]
    if T_wf is not None:
        R, p = T_wf.rotation.T @ R, (p - T_wf.translation) @ T_wf.rotation
    boxes = model.geom_aabb[geoms]
    centre = p + (R @ boxes[:, :3, None])[:, :, 0]
    half = (np.abs(R) @ boxes[:, 3:, None])[:, :, 0]
    return (centre - half).min(axis=0), (centre + half).max(axis=0)


def collision_geoms(cell: "Cell", name: str) -> np.ndarray:
    """Return the ids of an entity's collision geoms.

    Raises:
        CellError: When there is no such entity.
    """  # (n,)
    model = cell.model
    cell.find(name)
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    return np.flatnonzero(cell.contacts.geoms(name) & collides)


def nearest_free(cell: "Cell", name: str, within: float) -> float:
    """Return the distance from an entity to the nearest other free object [m].

    Args:
        cell: The cell.
        name: The entity.
        within: Upper bound: larger distances are not measured [m].

    Raises:
        CellError: When there is no such entity.
    """
    mine = collision_geoms(cell, name)
    nearest = within
    for other in cell.objects:
        if other == name or not cell.is_free(other):
            continue
        for a in mine:
            for b in collision_geoms(cell, other):
                distance = mujoco.mj_geomDistance(
                    cell.model, cell.data, int(a), int(b), within, None
                )
                nearest = min(nearest, float(distance))
    return nearest
