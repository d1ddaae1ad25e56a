"""The lip of a suction cup on a surface."""

from collections.abc import Sequence

import mujoco
import numpy as np

LIP_TRAVEL = 3e-3
"""Compression of the lip [m]; a cup farther from the surface does not seal."""

MAX_SAG = 0.5
"""Maximum depth of a curved surface at the lip with a seal, in radii of the cup [-].

Balls need at least 1.25 times the cup's radius.
"""

LIP_RADIUS = 1.5e-3
"""Radius of the spheres that form the lip of a built cup [m]."""

RAYS = 8
"""Number of points on the lip where a seal is checked, and of the lip's spheres."""

_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)


def ring(radius: float) -> np.ndarray:
    """Return points on the lip, in the frame of the tool [m]."""  # (n, 3)
    angle = 2.0 * np.pi * np.arange(RAYS) / RAYS
    return radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(RAYS)])


def seals(
    model: mujoco.MjModel, data: mujoco.MjData, site: int, radius: float, geoms: Sequence[int]
) -> bool:
    """Return whether geoms cover the whole lip of a radius [m].

    The tool's site is its centre, with the cup's axis as z axis.
    """
    R = data.site_xmat[site].reshape(3, 3)
    axis = R[:, 2].copy()
    points = data.site_xpos[site] + ring(radius) @ R.T - LIP_TRAVEL * axis
    farthest = 2.0 * LIP_TRAVEL + MAX_SAG * radius
    return all(
        any(0.0 <= _ray(model, data, geom, point, axis) <= farthest for geom in geoms)
        for point in points
    )


def _ray(
    model: mujoco.MjModel, data: mujoco.MjData, geom: int, point: np.ndarray, axis: np.ndarray
) -> float:
    """Return the distance to a geom along a ray [m]; -1 for none."""
    if model.geom_type[geom] == _MESH:
        return float(mujoco.mj_rayMesh(model, data, geom, point, axis))
    position, rotation = data.geom_xpos[geom], data.geom_xmat[geom]
    size, kind = model.geom_size[geom], int(model.geom_type[geom])
    return float(mujoco.mju_rayGeom(position, rotation, size, point, axis, kind))
