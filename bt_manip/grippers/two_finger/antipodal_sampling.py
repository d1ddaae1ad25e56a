"""Antipodal pairs of points, sampled on the surface of an object of any shape."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..solids import Polyhedron, Solid, contact_friction
from .hand import Hand

FINGER_CLEARANCE = 1.5e-3
"""Minimum clearance between each open finger and the object [m]."""

SURFACE_SAMPLES = 320  # sampled surface points
MAX_PAIRS = 60  # maximum number of selected pairs
MAX_PARALLEL = 10  # maximum number of selected pairs with similar direction and width
CONE_FRACTION = 0.8  # used fraction of the friction cone's half angle

_INSIDE = 1e-5  # [m] depth inside another solid above which a point is not on the surface
_MERGED = 1e-5  # [m] gap between solids up to which a line treats them as one
_SAME_CENTRE = 5e-3  # [m] distance of centres below which similar pairs are duplicates
_SIMILAR_WIDTH = 0.01  # [m] difference of widths
_SIMILAR_DIRECTION = 0.3  # [rad] angle between lines
_LEVER = 0.05  # [m] distance from the centre of mass that costs as much as missing contact
_FLAT = 1e-3  # [m] maximum unevenness of a surface in contact with a pad
_FACE_STEPS = 1e-3 * np.array([3.5, 7, 10, 20, 30, 40, 50, 60, 80, 100])  # [m]


class AntipodalPairs(NamedTuple):
    """Pairs of surface points on which two fingers press without slipping."""

    first: np.ndarray
    """Contact point of one finger [m]."""  # (n, 3)
    second: np.ndarray
    """Contact point of the other [m]."""  # (n, 3)
    normal_angle: np.ndarray
    """Largest angle between the line and a surface normal [rad]."""  # (n,)

    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the unit directions from first to second, and the distances [m]."""
        line = self.second - self.first
        width = np.linalg.norm(line, axis=1)
        return line / np.maximum(width, 1e-9)[:, None], width


class Chord(NamedTuple):
    """A part of a line that is inside an object."""

    enter: float  # [m] along the line
    leave: float
    normal_in: np.ndarray  # outward normals of the faces
    normal_out: np.ndarray


def sample_surface(
    solids: Sequence[Polyhedron], count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Sample points uniformly on the surface of an object.

    Args:
        solids: Its solids; they may overlap.
        count: Number of samples; points inside another solid are dropped.
        rng: Random generator.

    Returns:
        The points [m] and their outward normals.  # (n, 3) each
    """
    triangles = np.concatenate([solid.triangles for solid in solids])
    owner = np.repeat(np.arange(len(solids)), [len(solid.triangles) for solid in solids])
    normals = np.concatenate([solid.normals for solid in solids])
    edges = triangles[:, 1:] - triangles[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    drawn = rng.choice(len(triangles), size=count, p=area / area.sum())
    u, v = rng.uniform(size=(2, count))
    folded = u + v > 1.0
    u, v = np.where(folded, 1.0 - u, u), np.where(folded, 1.0 - v, v)
    points = triangles[drawn, 0] + u[:, None] * edges[drawn, 0] + v[:, None] * edges[drawn, 1]
    outside = np.ones(count, dtype=bool)
    for i, solid in enumerate(solids):
        depth = (solid.offsets - points @ solid.normals.T).min(axis=1)
        outside &= (owner[drawn] == i) | (depth < _INSIDE)
    return points[outside], normals[drawn][outside]


def intersect(
    solids: Sequence[Polyhedron], points: np.ndarray, directions: np.ndarray
) -> list[list[Chord]]:
    """Intersect lines with an object by Cyrus-Beck clipping against the planes of each solid.

    Args:
        solids: The object.
        points: One point on each line [m].  # (n, 3)
        directions: Unit directions of the lines.  # (n, 3)

    Returns:
        The parts of each line inside the object, in order.
    """
    parts: list[list[Chord]] = [[] for _ in points]
    for solid in solids:
        slope = directions @ solid.normals.T  # (n, m)
        ahead = solid.offsets - points @ solid.normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ahead / slope
        enters = np.where(slope < -1e-12, t, -np.inf)
        leaves = np.where(slope > 1e-12, t, np.inf)
        beside = ((np.abs(slope) <= 1e-12) & (ahead < 0.0)).any(axis=1)
        a, b = enters.argmax(axis=1), leaves.argmin(axis=1)
        rows = np.arange(len(points))
        t_in, t_out = enters[rows, a], leaves[rows, b]
        for i in np.flatnonzero((t_in < t_out) & ~beside):
            normals = solid.normals[a[i]], solid.normals[b[i]]
            parts[i].append(Chord(float(t_in[i]), float(t_out[i]), *normals))
    return [_merged(sorted(part, key=lambda p: p[:2])) for part in parts]


def _merged(parts: list[Chord]) -> list[Chord]:
    """Merge the parts of solids that overlap or touch along a line."""
    walls: list[Chord] = []
    for part in parts:
        if not walls or part.enter > walls[-1].leave + _MERGED:
            walls.append(part)
        elif part.leave > walls[-1].leave:
            walls[-1] = walls[-1]._replace(leave=part.leave, normal_out=part.normal_out)
    return walls


def antipodal_pairs(
    solids: Sequence[Polyhedron],
    *,
    cone: float,
    max_width: float,
    count: int,
    rng: np.random.Generator,
) -> AntipodalPairs:
    """Sample antipodal pairs: force-closure grasps of two point contacts with friction.

    A line is cast into the object from each of `count` surface points, against the normal or within
    the cone around it. The fingers press on the outermost two intersections, or on both sides of
    one of several walls. The pair is in force closure if the line is inside both friction cones
    (Nguyen, "Constructing force-closure grasps", 1988).

    Args:
        solids: The object.
        cone: Half angle of the friction cone [rad].
        max_width: Largest distance between the two points [m].
        count: Number of surface points.
        rng: Random generator.
    """
    points, normals = sample_surface(solids, count, rng)
    jitter = np.linalg.norm(normals, axis=1, keepdims=True) * rng.normal(size=normals.shape)
    amount = np.tan(cone) * rng.uniform(size=(len(points), 1)) ** 2
    amount[::2] = 0.0  # every second line is along the normal
    sideways = jitter - (jitter * normals).sum(axis=1, keepdims=True) * normals
    sideways /= np.maximum(np.linalg.norm(sideways, axis=1, keepdims=True), 1e-9)
    directions = -normals + amount * sideways
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    first, second, angles = [], [], []
    for point, direction, walls in zip(
        points, directions, intersect(solids, points, directions), strict=True
    ):
        between = [(walls[0], walls[-1])] if walls else []
        if len(walls) > 1:
            between += zip(walls, walls, strict=True)
        for one, other in between:  # all walls between the fingers, or one wall
            angle = max(_angle(-direction, one.normal_in), _angle(direction, other.normal_out))
            if other.leave - one.enter <= max_width and angle <= cone:
                first.append(point + one.enter * direction)
                second.append(point + other.leave * direction)
                angles.append(angle)
    return AntipodalPairs(
        np.reshape(first, (-1, 3)), np.reshape(second, (-1, 3)), np.array(angles, dtype=float)
    )


def _angle(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.arccos(np.clip(a @ b, -1.0, 1.0)))


def friction_cone(solids: Sequence[Solid]) -> float:
    """Return the half angle of the friction cone for grasps of an object [rad]."""
    return CONE_FRACTION * math.atan(contact_friction(solids))


def best_antipodal_pairs(
    solids: Sequence[Solid], hand: Hand, com: np.ndarray, rng: np.random.Generator
) -> tuple[AntipodalPairs, np.ndarray]:
    """Sample antipodal pairs; select the best that differ in position, direction or width.

    Args:
        solids: The object.
        hand: The gripper.
        com: The object's centre of mass, in its frame [m].  # (3,)
        rng: Random generator.

    Returns:
        The pairs, and the fraction of the pads in contact at each pair.  # (n,)
    """
    pairs = antipodal_pairs(
        [solid.polyhedron for solid in solids],
        cone=friction_cone(solids),
        max_width=hand.stroke - 2.0 * FINGER_CLEARANCE,
        count=SURFACE_SAMPLES,
        rng=rng,
    )
    contact = pad_contact(solids, pairs, hand)
    centre = 0.5 * (pairs.first + pairs.second)
    lever = np.linalg.norm(centre - com, axis=1) / _LEVER
    cost = lever + (1.0 - contact) + pairs.normal_angle
    kept: list[int] = []
    lines, width = pairs.lines()
    for i in np.argsort(cost, kind="stable"):
        similar = [
            k
            for k in kept
            if abs(float(lines[k] @ lines[i])) > math.cos(_SIMILAR_DIRECTION)
            and abs(width[k] - width[i]) < _SIMILAR_WIDTH
        ]
        duplicate = any(np.linalg.norm(centre[k] - centre[i]) < _SAME_CENTRE for k in similar)
        if len(similar) < MAX_PARALLEL and not duplicate:
            kept.append(int(i))
        if len(kept) == MAX_PAIRS:
            break
    return AntipodalPairs(*(column[kept] for column in pairs)), contact[kept]


def pad_contact(solids: Sequence[Solid], pairs: AntipodalPairs, hand: Hand) -> np.ndarray:
    """Estimate the fraction of the pads in contact by four lines parallel to each pair."""
    n = len(pairs.first)
    if not n:
        return np.zeros(0)
    line, width = pairs.lines()
    thin = np.eye(3)[np.argmin(np.abs(line), axis=1)]
    u = np.cross(line, thin)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(line, u)
    polyhedra = [solid.polyhedron for solid in solids]
    hits = np.zeros(n)
    for side in (u, -u, v, -v):
        beside = pairs.first + 0.6 * hand.pad * side
        for i, walls in enumerate(intersect(polyhedra, beside, line)):
            hits[i] += sum(_touches(walls, width[i]))
    return hits / 8.0


def face_extents(
    solids: Sequence[Solid], pairs: AntipodalPairs, approaches: Sequence[np.ndarray]
) -> np.ndarray:
    """Return the extent of both faces of each pair against an approach direction [m]."""
    n = len(_FACE_STEPS)  # (n,)
    repeated = AntipodalPairs(*(np.repeat(column, n, axis=0) for column in pairs))
    line, width = repeated.lines()
    out = np.repeat(np.reshape(approaches, (-1, 3)), n, axis=0) * np.tile(
        _FACE_STEPS, len(pairs.first)
    )[:, None]  # fmt: skip
    lines = intersect([solid.polyhedron for solid in solids], repeated.first - out, line)
    same = [all(_touches(walls, w)) for walls, w in zip(lines, width, strict=True)]
    steps = np.reshape(same, (-1, n)).cumprod(axis=1).sum(axis=1).astype(int)
    return np.concatenate([[0.0], _FACE_STEPS])[steps]


def _touches(walls: Sequence[Chord], width: float) -> tuple[bool, bool]:
    """Return whether both pads touch walls within `_FLAT` of the distance between them."""
    first = any(abs(wall.enter) < _FLAT for wall in walls)
    return first, any(abs(wall.leave - width) < _FLAT for wall in walls)
