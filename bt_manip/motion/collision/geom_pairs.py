"""Which geoms MuJoCo compares, and how it finds their distance."""

import mujoco
import numpy as np

_GEOM = mujoco.mjtGeom
_PLANE, _SPHERE = int(_GEOM.mjGEOM_PLANE), int(_GEOM.mjGEOM_SPHERE)
_CAPSULE, _CYLINDER = int(_GEOM.mjGEOM_CAPSULE), int(_GEOM.mjGEOM_CYLINDER)
_ELLIPSOID, _BOX, _MESH = (
    int(kind) for kind in (_GEOM.mjGEOM_ELLIPSOID, _GEOM.mjGEOM_BOX, _GEOM.mjGEOM_MESH)
)

# Of these MuJoCo computes the distance in closed form. Of two boxes apart it tells nothing where
# the nearest faces do not overlap, and what its iterations find of two convex shapes is off by
# centimetres at times when the margin is wide.
_EXACT = [
    *((_PLANE, other) for other in (_SPHERE, _CAPSULE, _ELLIPSOID, _CYLINDER, _BOX, _MESH)),
    *((_SPHERE, other) for other in (_SPHERE, _CAPSULE, _CYLINDER, _BOX)),
    *((_CAPSULE, other) for other in (_CAPSULE, _BOX)),
]
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


def exact(model: mujoco.MjModel) -> np.ndarray:
    """Mark the pairs of geoms whose distance MuJoCo finds exactly, however far they are apart."""
    table = np.zeros((int(_GEOM.mjNGEOMTYPES),) * 2, dtype=bool)  # (ngeom, ngeom)
    for first, second in _EXACT:
        table[first, second] = table[second, first] = True
    kind = model.geom_type
    return table[kind[:, np.newaxis], kind]


def margins(model: mujoco.MjModel) -> np.ndarray:
    """Give the distance from which on the physics pushes a pair of geoms apart [m]."""
    margin = model.geom_margin[:, np.newaxis] + model.geom_margin  # (ngeom, ngeom)
    first, second = model.pair_geom1, model.pair_geom2
    listed = np.maximum(margin[first, second], model.pair_margin)
    margin[first, second] = margin[second, first] = listed
    return margin
