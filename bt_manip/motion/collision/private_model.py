"""A copy of the compiled model that looks for contacts of what moves, and for no others."""

import copy

import mujoco
import numpy as np

_HALF = 16  # of the bits of contype and conaffinity


def moved_bodies(model: mujoco.MjModel, dofs: np.ndarray) -> np.ndarray:
    """Mark the bodies that degrees of freedom move, those that hang on them included."""
    moved = np.zeros(model.nbody, dtype=bool)
    moved[model.dof_bodyid[dofs]] = True
    for body in range(1, model.nbody):  # a parent always comes before its children
        moved[body] |= moved[model.body_parentid[body]]
    return moved  # (nbody,)


def private_copy(model: mujoco.MjModel, padding: float) -> mujoco.MjModel:
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


def look_only_at(own: mujoco.MjModel, model: mujoco.MjModel, bodies: np.ndarray) -> None:
    """Let a copy of a model leave out the contacts in which nothing of these bodies takes part.

    Which of the other contacts are seen does not change: MuJoCo asks of a pair whether the contype
    of either meets the conaffinity of the other. Here only what moves has a contype, and the
    conaffinity of the rest carries its contype in the upper half.

    Args:
        own: The copy, which is changed.
        model: The original.
        bodies: Mark what moves.  # (nbody,)
    """
    geoms = bodies[model.geom_bodyid]
    contype, conaffinity = model.geom_contype, model.geom_conaffinity
    if max(contype.max(initial=0), conaffinity.max(initial=0)) >= 1 << (_HALF - 1):
        return  # no room; whoever asks filters what is seen
    own.geom_contype[:] = np.where(geoms, contype | (conaffinity << _HALF), 0)
    own.geom_conaffinity[:] = np.where(geoms, conaffinity, conaffinity | (contype << _HALF))
    own.body_contype[:] = own.body_conaffinity[:] = 0
    np.bitwise_or.at(own.body_contype, own.geom_bodyid, own.geom_contype)
    np.bitwise_or.at(own.body_conaffinity, own.geom_bodyid, own.geom_conaffinity)


def look_only_between(
    own: mujoco.MjModel, model: mujoco.MjModel, first: np.ndarray, second: np.ndarray
) -> None:
    """Let a copy of a model leave out contacts that are not between two sets of bodies.

    Those that the model asks for by name are still seen.

    Args:
        own: The copy, which is changed.
        model: The original.
        first: Mark the bodies on the one side.  # (nbody,)
        second: Mark those on the other.  # (nbody,)
    """
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    own.geom_contype[:] = first[model.geom_bodyid] & solid
    own.geom_conaffinity[:] = second[model.geom_bodyid] & solid
    own.body_contype[:] = own.body_conaffinity[:] = 0
    np.bitwise_or.at(own.body_contype, own.geom_bodyid, own.geom_contype)
    np.bitwise_or.at(own.body_conaffinity, own.geom_bodyid, own.geom_conaffinity)
