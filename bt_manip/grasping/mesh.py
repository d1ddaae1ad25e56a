"""Where things of any shape can be gripped: meshes, and what is put together of several solids."""

import math
from collections.abc import Sequence

import numpy as np

from .antipodal import Pairs, antipodal_pairs, cross
from .hand import Hand
from .pinch import SLACK, Pinch, across
from .solid import Solid

SAMPLES = 320  # places that are drawn from the surface
KEPT = 60  # pairs that are looked at further
ALIKE = 10  # of them along the same line, at the most
SAFETY = 0.8  # share of the cone of friction that is used
_SLOPES = (0.0, math.pi / 4, -math.pi / 4, math.pi / 2, -math.pi / 2)
_APART = 5e-3  # [m] between the middles of pairs that are not the same
_WIDER = 0.01  # [m] between widths that are not the same
_TURNED = 0.3  # [rad] between lines that are not the same
_OUTWARDS = 1e-3 * np.array([3.5, 7, 10, 20, 30, 40, 50, 60, 80, 100])  # [m]
_FLAT = 1e-3  # [m] that a surface may fall back and still carry a pad


def cone_of_friction(solids: Sequence[Solid], hand: Hand) -> float:
    """Give half the angle of the cone of friction that grasps are to stay inside [rad].

    Of two geoms that touch, MuJoCo takes the greater friction.
    """
    return SAFETY * math.atan(max(hand.friction, min(solid.friction for solid in solids)))


def sampled_pairs(
    solids: Sequence[Solid], hand: Hand, centre: np.ndarray, rng: np.random.Generator
) -> list[tuple[np.ndarray, np.ndarray, float, float]]:
    """Find the best pairs of places that face each other.

    Args:
        solids: The object.
        hand: The hand.
        centre: The object's centre of mass, in its frame [m].  # (3,)
        rng: What the places are drawn from.

    Returns:
        Both places [m], how much of the pads lies on something there, and the slant [rad].
    """
    pairs = antipodal_pairs(
        [solid.polyhedron for solid in solids],
        cone=cone_of_friction(solids, hand),
        widest=hand.stroke - 2.0 * SLACK,
        count=SAMPLES,
        rng=rng,
    )
    contact = pad_contact(solids, pairs, hand)
    middle = 0.5 * (pairs.first + pairs.second)
    off = np.linalg.norm(middle - centre, axis=1) / 0.05
    cost = off + (1.0 - contact) + pairs.slant
    kept: list[int] = []
    lines = pairs.second - pairs.first
    width = np.linalg.norm(lines, axis=1)
    lines = lines / np.maximum(width, 1e-9)[:, None]
    for i in np.argsort(cost, kind="stable"):
        alike = [
            k
            for k in kept
            if abs(float(lines[k] @ lines[i])) > math.cos(_TURNED)
            and abs(width[k] - width[i]) < _WIDER
        ]
        near = any(np.linalg.norm(middle[k] - middle[i]) < _APART for k in alike)
        if len(alike) < ALIKE and not near:
            kept.append(int(i))
        if len(kept) == KEPT:
            break
    return [
        (pairs.first[i], pairs.second[i], float(contact[i]), float(pairs.slant[i])) for i in kept
    ]


def mesh_pinches(
    solids: Sequence[Solid],
    pairs: Sequence[tuple[np.ndarray, np.ndarray, float, float]],
    down: np.ndarray,
) -> list[Pinch]:
    """Give the ways to pairs of places: nearest to straight down, and turned about their line.

    Args:
        solids: The object.
        pairs: As `sampled_pairs` gives them.
        down: Straight down, in the object's frame; nothing comes from below.  # (3,)
    """
    lines = [second - first for first, second, _, _ in pairs]
    widths = [float(np.linalg.norm(line)) for line in lines]
    lines = [line / max(width, 1e-9) for line, width in zip(lines, widths, strict=True)]
    ways = [across(line, down, _SLOPES) for line in lines]
    straight = _straight(solids, pairs, [way[0] for way in ways])
    pinches = []
    for i, (first, second, contact, slant) in enumerate(pairs):
        middle = 0.5 * (first + second)
        for k, a in enumerate(ways[i]):
            if a @ down >= -0.1:
                far = straight[i] if k == 0 else 0.0
                for closing in (lines[i], -lines[i]):
                    pinches.append(Pinch(middle, closing, a, widths[i], far, contact, slant))
    return pinches


def _straight(
    solids: Sequence[Solid],
    pairs: Sequence[tuple[np.ndarray, np.ndarray, float, float]],
    approaches: Sequence[np.ndarray],
) -> list[float]:
    """Tell how far the two sides go on as they are against the approach, for each pair [m]."""
    if not pairs:
        return []
    n = len(_OUTWARDS)
    first = np.repeat([pair[0] for pair in pairs], n, axis=0)
    line = np.repeat([pair[1] - pair[0] for pair in pairs], n, axis=0)
    width = np.linalg.norm(line, axis=1)
    line = line / np.maximum(width, 1e-9)[:, None]
    out = np.repeat(approaches, n, axis=0) * np.tile(_OUTWARDS, len(pairs))[:, None]
    crossings = cross([solid.polyhedron for solid in solids], first - out, line)
    same = [
        any(abs(t) < _FLAT for t in crossing.enter)
        and any(abs(t - w) < _FLAT for t in crossing.leave)
        for crossing, w in zip(crossings, width, strict=True)
    ]
    steps = np.reshape(same, (len(pairs), n)).cumprod(axis=1).sum(axis=1)
    return [float(_OUTWARDS[k - 1]) if k else 0.0 for k in steps]


def pad_contact(solids: Sequence[Solid], pairs: Pairs, hand: Hand) -> np.ndarray:
    """Tell how much of the pads has something to lie on: lines beside each pair find out."""
    n = len(pairs.first)  # of the result, too
    if not n:
        return np.zeros(0)
    line = pairs.second - pairs.first
    width = np.linalg.norm(line, axis=1)
    line = line / np.maximum(width, 1e-9)[:, None]
    thin = np.eye(3)[np.argmin(np.abs(line), axis=1)]
    u = np.cross(line, thin)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(line, u)
    polyhedra = [solid.polyhedron for solid in solids]
    found = np.zeros(n)
    for side in (u, -u, v, -v):
        beside = pairs.first + 0.6 * hand.pad * side
        for i, crossing in enumerate(cross(polyhedra, beside, line)):
            flat_in = any(abs(t) < _FLAT for t in crossing.enter)
            flat_out = any(abs(t - width[i]) < _FLAT for t in crossing.leave)
            found[i] += flat_in + flat_out
    return found / 8.0
