"""Collision detection with MuJoCo in a scratch copy of the compiled model."""

import copy
from typing import NamedTuple

import mujoco
import numpy as np

_GEOM_BITS = 31  # usable bits of contype and conaffinity
_BODY_BITS = 16  # of each body id in an exclude signature


class GeomContacts(NamedTuple):
    """Pairs of geoms within the padding of each other.

    Attributes:
        first: Geom ids.  # (n,)
        second: Geom ids.  # (n,)
        distance: Distances less the model's margin, at which the physics starts to push; negative
            in penetration [m].  # (n,)
    """

    first: np.ndarray
    second: np.ndarray
    distance: np.ndarray


class CollisionModel:
    """A scratch copy of the compiled model for collision detection at any configuration.

    Contacts are those of the physics, for all kinds of geoms.

    Args:
        source: The model of the simulation.

    Attributes:
        model: The copy, with larger margins.
        data: Its data; write `qpos`, then call `collide`.
        padding: Distance up to which contacts are detected [m].
    """

    def __init__(self, source: mujoco.MjModel, padding: float) -> None:
        self._source, self.padding = source, padding
        self.model = copy.copy(source)
        self.model.pair_margin[:] += padding
        self.data = mujoco.MjData(self.model)
        self.inflate(np.zeros(source.nbody, dtype=bool), 0.0)

    def restrict_to(self, pairs: np.ndarray) -> None:
        """Detect contacts of given pairs of geoms only, and of the model's explicit pairs.

        MuJoCo tests two geoms if the contype of one and the conaffinity of the other share a bit.
        Each set of geoms with the same partners gets its own bit. If there are more sets than bits,
        additional pairs are tested, and the caller filters the contacts.

        Args:
            pairs: Symmetric mask.  # (ngeom, ngeom)
        """
        model = self.model
        sets: dict[bytes, int] = {}
        rows = (row.tobytes() for row in np.packbits(pairs, axis=1))
        set_of = np.array([sets.setdefault(row, len(sets)) for row in rows], dtype=int)
        if len(sets) > _GEOM_BITS:
            model.geom_contype[:] = model.geom_conaffinity[:] = pairs.any(axis=1)
        else:
            bits = 1 << np.arange(len(sets))
            representative = np.unique(set_of, return_index=True)[1]
            partners = pairs[np.ix_(representative, representative)] @ bits
            model.geom_contype[:] = bits[set_of]
            model.geom_conaffinity[:] = partners[set_of]
        model.body_contype[:] = model.body_conaffinity[:] = 0
        np.bitwise_or.at(model.body_contype, model.geom_bodyid, model.geom_contype)
        np.bitwise_or.at(model.body_conaffinity, model.geom_bodyid, model.geom_conaffinity)

    def inflate(self, bodies: np.ndarray, by: float) -> None:
        """Set a margin around given bodies, and none around others.

        Args:
            bodies: Mask.  # (nbody,)
            by: Margin [m].
        """
        own, source = self.model, self._source
        half = 0.5 * self.padding  # MuJoCo adds the margins of both geoms
        own.geom_margin[:] = source.geom_margin + half + by * bodies[source.geom_bodyid]
        own.body_margin[:] = source.body_margin + half + by * bodies

    def copy_state(self, data: mujoco.MjData) -> None:
        """Copy the positions of all joints and mocap bodies from the simulation."""
        self.data.qpos[:] = data.qpos
        self.data.mocap_pos[:] = data.mocap_pos
        self.data.mocap_quat[:] = data.mocap_quat

    def update_kinematics(self) -> None:
        """Compute the poses of bodies and geoms at ``data.qpos``."""
        mujoco.mj_kinematics(self.model, self.data)

    def collide(self) -> int:
        """Detect contacts at ``data.qpos`` and return their number."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)
        return int(self.data.ncon)

    @property
    def contacts(self) -> GeomContacts:
        """The contacts detected by `collide`."""
        contact = self.data.contact
        geoms = contact.geom.copy()
        distance = contact.dist - contact.includemargin + self.padding
        return GeomContacts(geoms[:, 0], geoms[:, 1], distance)


def collidable_pairs(model: mujoco.MjModel) -> np.ndarray:
    """Return the mask of geom pairs that MuJoCo tests for contacts.

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
    first, second = model.pair_geom1, model.pair_geom2  # always tested
    pairs[first, second] = pairs[second, first] = True
    return pairs


def pair_margins(model: mujoco.MjModel) -> np.ndarray:
    """Return the distance at which the physics starts to push each pair of geoms apart [m]."""
    margin = model.geom_margin[:, np.newaxis] + model.geom_margin  # (ngeom, ngeom)
    first, second = model.pair_geom1, model.pair_geom2
    explicit = np.maximum(margin[first, second], model.pair_margin)
    margin[first, second] = margin[second, first] = explicit
    return margin
