"""What something would be inside of."""

from typing import NamedTuple

import mujoco
import numpy as np

from bt_manip.cell.exceptions import OverlapError
from bt_manip.cell.naming import BodyNames, entity_of


class Overlap(NamedTuple):
    """The deepest overlap with something else."""

    other: str
    """Name of the body."""
    depth: float
    """How deep [m]."""

    def __str__(self) -> str:
        """Say it in words."""
        return f"{1e3 * self.depth:.1f} mm inside '{self.other}'"


def deepest_overlap(
    model: mujoco.MjModel, data: mujoco.MjData, labels: BodyNames, name: str
) -> Overlap | None:
    """Find what an entity is inside of, by geoms that can touch each other.

    Args:
        model: The compiled model.
        data: Its data, with contacts of the poses that are asked about.
        labels: Names of the geoms.
        name: The entity.
    """
    mine = np.array([entity_of(label) == name for label in labels.of_geom])
    found = None
    geoms, depths = data.contact.geom, -data.contact.dist
    for i in np.flatnonzero(mine[geoms[:, 0]] != mine[geoms[:, 1]]) if len(geoms) else ():
        if depths[i] > (found.depth if found else 0.0):
            a, b = geoms[i]
            found = Overlap(labels.of_geom[b if mine[a] else a], float(depths[i]))
    for a, b in _static_pairs(model, data, mine):
        depth = -mujoco.mj_geomDistance(model, data, a, b, 0.0, None)
        if depth > (found.depth if found else 0.0):
            found = Overlap(labels.of_geom[b], float(depth))
    return found


def refuse_overlap(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    labels: BodyNames,
    name: str,
    accepted: float,
    verb: str = "added",
) -> None:
    """Refuse an entity that is deeper inside something else than is accepted [m].

    Args:
        model: The compiled model.
        data: Its data, with contacts of the poses that are asked about.
        labels: Names of the geoms.
        name: The entity.
        accepted: How deep it may be.
        verb: What cannot be done with it then, for the message.

    Raises:
        OverlapError: When it is.
    """
    found = deepest_overlap(model, data, labels, name)
    if found is not None and found.depth > accepted:
        raise OverlapError(
            f"'{name}' cannot be {verb}: it would be {found}; "
            f"up to {1e3 * accepted:g} mm are accepted"
        )


def _static_pairs(
    model: mujoco.MjModel, data: mujoco.MjData, mine: np.ndarray
) -> list[tuple[int, int]]:
    """Pair fixed geoms that are near each other: MuJoCo makes no contacts between those."""
    fixed = model.body_weldid[model.geom_bodyid] == 0
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    own, others = (np.flatnonzero(fixed & solid & side) for side in (mine, ~mine))
    pairs = []
    for a in own:
        touch = (model.geom_contype[a] & model.geom_conaffinity[others]) | (
            model.geom_contype[others] & model.geom_conaffinity[a]
        )
        plane = model.geom_rbound[others] == 0.0
        reach = model.geom_rbound[a] + model.geom_rbound[others]
        apart = np.linalg.norm(data.geom_xpos[others] - data.geom_xpos[a], axis=1)
        near = (touch != 0) & (plane | (model.geom_rbound[a] == 0.0) | (apart < reach))
        pairs += [(int(a), int(b)) for b in others[near]]
    return pairs
