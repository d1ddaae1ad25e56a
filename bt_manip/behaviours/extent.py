"""Bounding boxes of entities, and distances between them."""

import mujoco
import numpy as np

from bt_manip.cell import Cell, CellError, as_object


def extent(cell: Cell, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the axis-aligned bounding box of an entity's collision geometry in the world [m].

    Args:
        cell: The cell.
        name: The entity; geoms without collisions are left out.

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
    centre = data.geom_xpos[geoms] + np.einsum("nij,nj->ni", R, model.geom_aabb[geoms, :3])
    half = np.einsum("nij,nj->ni", np.abs(R), model.geom_aabb[geoms, 3:])
    return (centre - half).min(axis=0), (centre + half).max(axis=0)


def collision_geoms(cell: Cell, name: str) -> np.ndarray:
    """List the collision geoms of an entity.

    Raises:
        CellError: When there is no such entity.
    """  # (n,)
    model = cell.model
    cell.find(name)
    bodies = [
        body
        for body in range(1, model.nbody)
        if (mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or "").partition("/")[0]
        == name
    ]
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    return np.flatnonzero(np.isin(model.geom_bodyid, bodies) & collides)


def nearest_free(cell: Cell, name: str, within: float) -> float:
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
    for other, entity in cell.objects.items():
        if other == name or not as_object(entity).free:
            continue
        for a in mine:
            for b in collision_geoms(cell, other):
                distance = mujoco.mj_geomDistance(
                    cell.model, cell.data, int(a), int(b), within, None
                )
                nearest = min(nearest, float(distance))
    return nearest
