"""A copy of the compiled model that looks for contacts of what moves, and for no others."""

import copy

import mujoco
import numpy as np

_BITS = 31  # of contype and conaffinity


def moved_bodies(model: mujoco.MjModel, dofs: np.ndarray) -> np.ndarray:
    """Mark the bodies that degrees of freedom move, those that hang on them included."""
    moved = np.zeros(model.nbody, dtype=bool)
    moved[model.dof_bodyid[dofs]] = True
    for body in range(1, model.nbody):  # a parent always comes before its children
        moved[body] |= moved[model.body_parentid[body]]
    return moved  # (nbody,)


def scratch_model(model: mujoco.MjModel, padding: float) -> mujoco.MjModel:
    """Copy a model, and let it see contacts from farther away.

    Args:
        model: What is simulated.
        padding: How much farther [m].
    """
    own = copy.copy(model)
    for margins in (own.geom_margin, own.body_margin):
        margins += 0.5 * padding  # MuJoCo adds those of the two sides
    own.pair_margin[:] += padding
    return own


def restrict_pairs(own: mujoco.MjModel, pairs: np.ndarray) -> None:
    """Let a copy of a model look at some pairs of geoms, and at those that it asks for by name.

    MuJoCo compares geoms when a bit of the contype of either is one of the conaffinity of the
    other. Here all geoms that are compared with the same others have a bit for themselves.

    Args:
        own: The copy, which is changed. Where there are not enough bits it looks at all geoms of
            any pair: whoever asks filters what is seen.
        pairs: Mark them; it is symmetric.  # (ngeom, ngeom)
    """
    kinds: dict[bytes, int] = {}
    rows = (row.tobytes() for row in np.packbits(pairs, axis=1))
    kind = np.array([kinds.setdefault(row, len(kinds)) for row in rows], dtype=int)
    if len(kinds) > _BITS:
        own.geom_contype[:] = own.geom_conaffinity[:] = pairs.any(axis=1)
    else:
        bits = 1 << np.arange(len(kinds))
        # Geoms of one kind are compared with the same kinds: any of them stands for the others.
        one_of = np.unique(kind, return_index=True)[1]
        own.geom_contype[:] = bits[kind]
        own.geom_conaffinity[:] = (pairs[np.ix_(one_of, one_of)] @ bits)[kind]
    own.body_contype[:] = own.body_conaffinity[:] = 0
    np.bitwise_or.at(own.body_contype, own.geom_bodyid, own.geom_contype)
    np.bitwise_or.at(own.body_conaffinity, own.geom_bodyid, own.geom_conaffinity)
