"""Pairs of places on an object's surface that face each other, found by sampling."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .polyhedron import Polyhedron

_INSIDE = 1e-5  # [m] inside another solid from which on a place is not on the surface
_TOGETHER = 1e-5  # [m] between solids that are one for a line


class Pairs(NamedTuple):
    """Lines through an object, from where they enter it to where they leave it."""

    first: np.ndarray
    """Where a finger presses [m]."""  # (n, 3)
    second: np.ndarray
    """Where the other does [m]."""  # (n, 3)
    slant: np.ndarray
    """Largest angle between the line and the normals of the two faces [rad]."""  # (n,)


class Crossing(NamedTuple):
    """Where one line goes through an object: it enters and leaves it, maybe several times."""

    enter: list[float]  # [m] along the line
    leave: list[float]
    normal_in: list[np.ndarray]  # outward, of the faces
    normal_out: list[np.ndarray]


def sample_surface(
    solids: Sequence[Polyhedron], count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Draw places evenly from the surface of several solids that are one body.

    Args:
        solids: They may overlap.
        count: How many places are drawn; those inside another solid are left out.
        rng: What is drawn from.

    Returns:
        The places, and the outward normals there.  # (n, 3) each
    """
    triangles = np.concatenate([solid.triangles for solid in solids])
    owner = np.repeat(np.arange(len(solids)), [len(solid.triangles) for solid in solids])
    normals = np.concatenate([solid.normals for solid in solids])
    edges = triangles[:, 1:] - triangles[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    chosen = rng.choice(len(triangles), size=count, p=area / area.sum())
    u, v = rng.uniform(size=(2, count))
    folded = u + v > 1.0
    u, v = np.where(folded, 1.0 - u, u), np.where(folded, 1.0 - v, v)
    places = triangles[chosen, 0] + u[:, None] * edges[chosen, 0] + v[:, None] * edges[chosen, 1]
    outside = np.ones(count, dtype=bool)
    for i, solid in enumerate(solids):
        depth = (solid.offsets - places @ solid.normals.T).min(axis=1)
        outside &= (owner[chosen] == i) | (depth < _INSIDE)
    return places[outside], normals[chosen][outside]


def cross(
    solids: Sequence[Polyhedron], places: np.ndarray, directions: np.ndarray
) -> list[Crossing]:
    """Follow lines through an object.

    A convex solid is left by the nearest of the planes ahead and entered by the farthest of those
    behind (Cyrus and Beck's clipping).

    Args:
        solids: The object.
        places: On the lines [m].  # (n, 3)
        directions: Of the lines; unit.  # (n, 3)
    """
    parts: list[list[tuple[float, float, np.ndarray, np.ndarray]]] = [[] for _ in places]
    for solid in solids:
        speed = directions @ solid.normals.T  # (n, m)
        ahead = solid.offsets - places @ solid.normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ahead / speed
        enters = np.where(speed < -1e-12, t, -np.inf)
        leaves = np.where(speed > 1e-12, t, np.inf)
        beside = ((np.abs(speed) <= 1e-12) & (ahead < 0.0)).any(axis=1)
        a, b = enters.argmax(axis=1), leaves.argmin(axis=1)
        rows = np.arange(len(places))
        t_in, t_out = enters[rows, a], leaves[rows, b]
        for i in np.flatnonzero((t_in < t_out) & ~beside):
            parts[i].append((float(t_in[i]), float(t_out[i]), solid.normals[a[i]],
                             solid.normals[b[i]]))  # fmt: skip
    return [_merged(sorted(part, key=lambda p: p[:2])) for part in parts]


def _merged(parts: list[tuple[float, float, np.ndarray, np.ndarray]]) -> Crossing:
    """Make one of solids that overlap or touch on a line."""
    found = Crossing([], [], [], [])
    for enter, leave, normal_in, normal_out in parts:
        if found.leave and enter <= found.leave[-1] + _TOGETHER:
            if leave > found.leave[-1]:
                found.leave[-1], found.normal_out[-1] = leave, normal_out
            continue
        found.enter.append(enter)
        found.leave.append(leave)
        found.normal_in.append(normal_in)
        found.normal_out.append(normal_out)
    return found


def antipodal_pairs(
    solids: Sequence[Polyhedron],
    *,
    cone: float,
    widest: float,
    count: int,
    rng: np.random.Generator,
) -> Pairs:
    """Find pairs of places at which two fingers press without slipping.

    From each of many places on the surface a line goes in against the normal, or inside the cone
    around that. Fingers press on the outermost two places of the line, or on both sides of one
    of several walls that it goes through. They do not slip where the line is inside the cones of
    friction of both (Nguyen, "Constructing force-closure grasps", 1988).

    Args:
        solids: The object.
        cone: Half the angle of the cone of friction [rad].
        widest: Greatest distance of the two [m].
        count: How many places are drawn.
        rng: What they are drawn from.
    """
    places, normals = sample_surface(solids, count, rng)
    jitter = np.linalg.norm(normals, axis=1, keepdims=True) * rng.normal(size=normals.shape)
    amount = np.tan(cone) * rng.uniform(size=(len(places), 1)) ** 2
    amount[::2] = 0.0  # every other goes straight in
    sideways = jitter - (jitter * normals).sum(axis=1, keepdims=True) * normals
    sideways /= np.maximum(np.linalg.norm(sideways, axis=1, keepdims=True), 1e-9)
    directions = -normals + amount * sideways
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    first, second, slants = [], [], []
    for place, direction, crossing in zip(
        places, directions, cross(solids, places, directions), strict=True
    ):
        for i, j in _ends(len(crossing.enter)):
            start, end = crossing.enter[i], crossing.leave[j]
            slant = max(
                _angle(-direction, crossing.normal_in[i]), _angle(direction, crossing.normal_out[j])
            )
            if end - start <= widest and slant <= cone:
                first.append(place + start * direction)
                second.append(place + end * direction)
                slants.append(slant)
    return Pairs(
        np.reshape(first, (-1, 3)), np.reshape(second, (-1, 3)), np.array(slants, dtype=float)
    )


def _ends(walls: int) -> list[tuple[int, int]]:
    """List what can be between the fingers: all walls on a line, or one of them."""
    if walls == 0:
        return []
    return [(0, walls - 1), *((i, i) for i in range(walls) if walls > 1)]


def _angle(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.arccos(np.clip(a @ b, -1.0, 1.0)))
