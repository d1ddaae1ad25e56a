"""Which geoms MuJoCo compares, and how it finds their distance."""

import mujoco
import numpy as np

_GEOM = mujoco.mjtGeom
_BOX = int(_GEOM.mjGEOM_BOX)
_FIELDS = [int(kind) for kind in (_GEOM.mjGEOM_HFIELD, _GEOM.mjGEOM_SDF)]
_BODY_BITS = 16  # of a signature


def comparable(model: mujoco.MjModel) -> np.ndarray:
    """Mark the pairs of geoms that MuJoCo compares, as its documentation says it selects them.

    https://mujoco.readthedocs.io/en/stable/computation/index.html#selection
    """  # (ngeom, ngeom)
    contype, conaffinity = model.geom_contype, model.geom_conaffinity
    bits = (contype[:, np.newaxis] & conaffinity) != 0
    weld = model.body_weldid
    parent = weld[model.body_parentid[weld]]
    bodies = weld[:, np.newaxis] != weld
    if not model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT):
        child = (weld[:, np.newaxis] == parent) & (weld[:, np.newaxis] != 0) & (weld != 0)
        bodies &= ~(child | child.T)
    excluded = np.array(model.exclude_signature)
    first, second = excluded >> _BODY_BITS, excluded & ((1 << _BODY_BITS) - 1)
    bodies[first, second] = bodies[second, first] = False
    of_geom = model.geom_bodyid
    pairs = (bits | bits.T) & bodies[of_geom[:, np.newaxis], of_geom]
    first, second = model.pair_geom1, model.pair_geom2  # these are compared in any case
    pairs[first, second] = pairs[second, first] = True
    return pairs


def scaled(model: mujoco.MjModel) -> np.ndarray:
    """Mark the pairs of geoms whose contacts are nearer than they are, the farther the more.

    Of two boxes corner to corner MuJoCo gives the gap along the axes of one, not the distance.
    """  # (ngeom, ngeom)
    box = model.geom_type == _BOX
    return box[:, np.newaxis] & box


def distance_unknown(model: mujoco.MjModel) -> np.ndarray:
    """Mark the pairs of geoms of which MuJoCo gives no distance, only contacts."""
    field = np.isin(model.geom_type, _FIELDS)  # (ngeom, ngeom)
    return field[:, np.newaxis] | field


def margins(model: mujoco.MjModel) -> np.ndarray:
    """Give the distance from which on the physics pushes a pair of geoms apart [m]."""
    margin = model.geom_margin[:, np.newaxis] + model.geom_margin  # (ngeom, ngeom)
    first, second = model.pair_geom1, model.pair_geom2
    listed = np.maximum(margin[first, second], model.pair_margin)
    margin[first, second] = margin[second, first] = listed
    return margin
