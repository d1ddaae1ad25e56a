"""Penetration of an entity into others."""

from typing import NamedTuple

import mujoco
import numpy as np

from ..exceptions import OverlapError
from ..naming import BodyNames, entity_of


class Overlap(NamedTuple):
    """The deepest penetration of a body into another one."""

    body: str
    """Name of the body, or of its entity if it has a single body."""
    other: str
    """Name of the other body."""
    depth: float
    """Penetration depth [m]."""

    def __str__(self) -> str:
        """Describe the overlap."""
        return f"'{self.body}' would be {1e3 * self.depth:.1f} mm inside '{self.other}'"


def deepest_overlap(
    model: mujoco.MjModel, data: mujoco.MjData, body_names: BodyNames, name: str
) -> Overlap | None:
    """Return the deepest overlap of an entity's collision geoms with others, or None.

    Args:
        model: The compiled model.
        data: Its data, after ``mj_fwdPosition``.
        body_names: Its names.
        name: The entity.
    """
    label = body_names.of_geom
    mine = np.array([entity_of(body) == name for body in label])
    found = None
    geoms, depths = data.contact.geom, -data.contact.dist
    for i in np.flatnonzero(mine[geoms[:, 0]] != mine[geoms[:, 1]]) if len(geoms) else ():
        if depths[i] > (found.depth if found else 0.0):
            own, other = geoms[i] if mine[geoms[i, 0]] else geoms[i, ::-1]
            found = Overlap(label[own], label[other], float(depths[i]))
    for a, b in _static_pairs(model, data, mine):
        depth = -mujoco.mj_geomDistance(model, data, a, b, 0.0, None)
        if depth > (found.depth if found else 0.0):
            found = Overlap(label[a], label[b], float(depth))
    return found


def refuse_overlap(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    body_names: BodyNames,
    name: str,
    max_overlap: float,
    verb: str = "added",
) -> None:
    """Raise an error if an entity penetrates others too deeply.

    Args:
        model: The compiled model.
        data: Its data, after ``mj_fwdPosition``.
        body_names: Its names.
        name: The entity.
        max_overlap: Largest accepted penetration [m].
        verb: Participle of the attempted action, for the message: ``added``.

    Raises:
        OverlapError: If the penetration is deeper.
    """
    found = deepest_overlap(model, data, body_names, name)
    if found is not None and found.depth > max_overlap:
        raise OverlapError(
            f"'{name}' cannot be {verb}: {found}; up to {1e3 * max_overlap:g} mm are accepted"
        )


def _static_pairs(
    model: mujoco.MjModel, data: mujoco.MjData, mine: np.ndarray
) -> list[tuple[int, int]]:
    """Return pairs of fixed geoms with overlapping bounds; MuJoCo does not check these."""
    fixed = model.body_weldid[model.geom_bodyid] == 0
    own, others = (np.flatnonzero(fixed & side) for side in (mine, ~mine))
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
