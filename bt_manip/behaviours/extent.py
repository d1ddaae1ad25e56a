"""How far an entity reaches, as it lies now."""

import mujoco
import numpy as np

from bt_manip.cell import Cell, CellError, as_object


def extent(cell: Cell, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Give the box around an entity's collision shapes, along the axes of the world [m].

    Args:
        cell: The cell.
        name: The entity; shapes that can touch nothing do not count.

    Returns:
        Its lower and its upper corner.  # 2 x (3,)

    Raises:
        CellError: When there is none of that name, or it has no shape that can touch anything.
    """
    model, data = cell.model, cell.data
    geoms = solid_geoms(cell, name)
    if not len(geoms):
        raise CellError(f"'{name}' has no shape that could touch anything")
    R = data.geom_xmat[geoms].reshape(-1, 3, 3)
    middle = data.geom_xpos[geoms] + np.einsum("nij,nj->ni", R, model.geom_aabb[geoms, :3])
    reach = np.einsum("nij,nj->ni", np.abs(R), model.geom_aabb[geoms, 3:])
    return (middle - reach).min(axis=0), (middle + reach).max(axis=0)


def solid_geoms(cell: Cell, name: str) -> np.ndarray:
    """List the geoms of an entity that can touch something.

    Raises:
        CellError: When there is none of that name.
    """  # (n,)
    model = cell.model
    cell.find(name)
    bodies = [
        body
        for body in range(1, model.nbody)
        if (mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or "").partition("/")[0]
        == name
    ]
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    return np.flatnonzero(np.isin(model.geom_bodyid, bodies) & solid)


def nearest_free(cell: Cell, name: str, within: float) -> float:
    """Give the distance from an entity to the nearest other one that moves freely [m].

    Args:
        cell: The cell.
        name: The entity.
        within: Larger distances are not measured; then this is the answer [m].

    Raises:
        CellError: When there is none of that name.
    """
    mine = solid_geoms(cell, name)
    nearest = within
    for other, entity in cell.objects.items():
        if other == name or not as_object(entity).free:
            continue
        for a in mine:
            for b in solid_geoms(cell, other):
                distance = mujoco.mj_geomDistance(
                    cell.model, cell.data, int(a), int(b), within, None
                )
                nearest = min(nearest, float(distance))
    return nearest
