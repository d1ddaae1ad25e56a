"""Antipodal grasps of primitives and meshes, and their depth."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.robots import GraspCandidates

from ..solids import SIDEWAYS, Solid, contact_friction, least_width
from .antipodal_sampling import (
    FINGER_CLEARANCE,
    AntipodalPairs,
    best_antipodal_pairs,
    face_extents,
    friction_cone,
)
from .hand import BELOW, CLOSING_MARGIN, Hand

GRIP_DEPTH = 0.010
"""Depth of the tool centre point below the upper edge of the gripped faces [m].

A cube is gripped this far below its top. Round sides are gripped at their widest point. The palm
or the support surface may require a smaller depth.
"""

CONTACT_WEIGHT = 0.3
"""Cost of point contacts: pads that touch the object at the two contact points only."""

ANGLE_WEIGHT = 1.0
"""Cost of surface normals at `_MAX_ANGLE` or more from the closing direction."""

SLACK_WEIGHT = 0.3
"""Cost of a gripper that opens no wider than the object; zero from `_MIN_SLACK` on."""

DEPTH_WEIGHT = 0.5
"""Cost of a tool that is a finger length short of the preferred depth."""

_MAX_ANGLE = 0.25 * math.pi  # [rad]
_MIN_SLACK = 5e-3  # [m] on each side

MAX_PRIMITIVES = 8  # largest number of solids of an object that are gripped separately

_PALM_CLEARANCE = 3e-3  # [m] between the palm and the object
_TIP_CLEARANCE = (5e-3, 1e-3)  # [m] of the tips above the object's far side: preferred, minimum
_MIN_OVERLAP = 4e-3  # [m] of the fingers with flat faces
_TIP_OVERHANG = 2e-3  # [m] minimum overhang of the tips beyond a point contact
_MAX_OFF_CENTRE = 0.25  # radii from the widest point of round sides at which the tips may end

_LONG = 3.0  # half lengths in pad half widths from which on a box is also gripped off its centre
_OFF_CENTRE = 0.6  # of the half length at which it is gripped then
_EDGE_CONTACT = 0.5  # fraction of the pads in contact where a box is approached over an edge
_LINE_CONTACT = 0.8  # along a generatrix of a cylinder
_POINT_CONTACT = 0.6  # on a sphere
_DIAGONAL = np.sqrt(0.5)
_EIGHTHS = tuple(2 * math.pi * k / 8 for k in range(8))  # [rad] of a turn


class AntipodalGrasp(NamedTuple):
    """A pair of antipodal contacts and an approach direction, before the depth is set.

    Attributes:
        centre: Midpoint of the two contacts, in the object's frame [m].  # (3,)
        closing: Direction from one contact to the other; unit.  # (3,)
        approach: Approach direction, orthogonal to that; unit.  # (3,)
        width: Distance between the two contacts [m].
        face_extent: Extent of both faces against the approach; 0 for round sides [m].
        contact: Fraction of the pads in contact, 0 to 1.
        normal_angle: Largest angle between the closing direction and a surface normal [rad].
        radius: Radius of round sides, which may be gripped slightly off their widest point [m].
        part: Index of the gripped solid; -1 for the whole object.
    """

    centre: np.ndarray
    closing: np.ndarray
    approach: np.ndarray
    width: float
    face_extent: float = 0.0
    contact: float = 1.0
    normal_angle: float = 0.0
    radius: float = 0.0
    part: int = -1


def box_grasps(solid: Solid, hand: Hand, down: np.ndarray) -> Iterator[AntipodalGrasp]:
    """Yield the grasps of a box: pairs of opposite faces with each approach direction.

    The approach is over one of the four other faces or an edge between them, with either finger
    first. A long box is also gripped on both sides of its centre.

    Args:
        solid: A box.
        hand: The gripper.
        down: Straight down in the object's frame; grasps from below are excluded.  # (3,)
    """
    R, centre, half = solid.T_os.rotation, solid.T_os.translation, solid.size
    for i in range(3):
        width = 2.0 * float(half[i])
        if not _fits(width, hand):
            continue
        j, k = (i + 1) % 3, (i + 2) % 3
        for closing in (R[:, i], -R[:, i]):
            for along, other in ((j, k), (k, j)):
                contact = min(1.0, half[other] / hand.pad)
                for a in (R[:, along], -R[:, along]):
                    if a @ down < BELOW:
                        continue
                    extent, points = float(half[along]), [centre]
                    if half[other] > _LONG * hand.pad:
                        shift = _OFF_CENTRE * (half[other] - hand.pad) * R[:, other]
                        points += [centre + shift, centre - shift]
                    for point in points:
                        yield AntipodalGrasp(point, closing, a, width, extent, contact)
            for sign_j, sign_k in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                a = _DIAGONAL * (sign_j * R[:, j] + sign_k * R[:, k])
                if a @ down >= BELOW:
                    extent = _DIAGONAL * float(min(half[j], half[k]))
                    yield AntipodalGrasp(centre, closing, a, width, extent, _EDGE_CONTACT)


def cylinder_grasps(solid: Solid, hand: Hand, down: np.ndarray) -> Iterator[AntipodalGrasp]:
    """Yield the grasps of a cylinder or capsule: across its diameter and along its length.

    A diameter is approached along the axis, and across the axis at the centre and on both sides.

    Args:
        solid: A cylinder or a capsule.
        hand: The gripper.
        down: Straight down in the object's frame; grasps from below are excluded.  # (3,)
    """
    axis, centre = solid.T_os.rotation[:, 2], solid.T_os.translation
    radius, half = float(solid.size[0]), float(solid.size[1])
    end = half + (radius if solid.kind == "capsule" else 0.0)
    diameter, length = 2.0 * radius, 2.0 * end
    if _fits(diameter, hand):
        for a in (axis, -axis):
            if a @ down >= BELOW:
                x = solid.T_os.rotation[:, 0]
                y = np.cross(a, x)
                for yaw in _EIGHTHS:
                    closing = math.cos(yaw) * x + math.sin(yaw) * y
                    yield AntipodalGrasp(centre, closing, a, diameter, half, _LINE_CONTACT)
        free = max(half - hand.pad, 0.0)
        shifts = (0.0, _OFF_CENTRE * free, -_OFF_CENTRE * free) if free > hand.pad else (0.0,)
        for a in _orthogonal(axis, down, _EIGHTHS):
            if a @ down >= BELOW:
                for shift in shifts:
                    for closing in (np.cross(axis, a), np.cross(a, axis)):
                        yield AntipodalGrasp(
                            centre + shift * axis, closing, a, diameter,
                            contact=_LINE_CONTACT, radius=radius,
                        )  # fmt: skip
    if _fits(length, hand):
        flat = solid.kind == "cylinder"
        contact = min(1.0, radius / hand.pad) if flat else _POINT_CONTACT
        extent = 0.5 * radius if flat else 0.0
        for a in _orthogonal(axis, down, SIDEWAYS):
            if a @ down >= BELOW:
                yield AntipodalGrasp(centre, axis, a, length, extent, contact)
                yield AntipodalGrasp(centre, -axis, a, length, extent, contact)


def sphere_grasps(solid: Solid, hand: Hand, down: np.ndarray) -> Iterator[AntipodalGrasp]:
    """Yield the grasps of a sphere: horizontal diameters, approached vertically to horizontally.

    Args:
        solid: A sphere.
        hand: The gripper.
        down: Straight down in the object's frame.  # (3,)
    """
    radius = float(solid.size[0])
    if not _fits(2.0 * radius, hand):
        return
    vertical = down / np.linalg.norm(down)
    for i, closing in enumerate(_orthogonal(vertical, np.array([1.0, 0.0, 0.0]), _EIGHTHS)):
        first = (-1.0) ** i  # alternate the finger on the far side
        for tilt in (0.0, math.pi / 4, math.pi / 2):
            a = math.cos(tilt) * vertical + first * math.sin(tilt) * np.cross(closing, vertical)
            yield AntipodalGrasp(
                solid.T_os.translation, closing, a, 2.0 * radius,
                contact=_POINT_CONTACT, radius=radius,
            )  # fmt: skip


def sampled_grasps(
    solids: Sequence[Solid], pairs: AntipodalPairs, contact: np.ndarray, down: np.ndarray
) -> Iterator[AntipodalGrasp]:
    """Yield the grasps at sampled pairs, with approaches from the one nearest to straight down on.

    Args:
        solids: The object.
        pairs: Its antipodal pairs.
        contact: Fraction of the pads in contact at each pair.  # (n,)
        down: Straight down in the object's frame; grasps from below are excluded.  # (3,)
    """
    widths = [float(np.linalg.norm(b - a)) for a, b in zip(pairs.first, pairs.second, strict=True)]
    lines = (pairs.second - pairs.first) / np.maximum(widths, 1e-9)[:, None]
    approaches = [_orthogonal(line, down, SIDEWAYS) for line in lines]
    extents = face_extents(solids, pairs, [a[0] for a in approaches])
    for i, line in enumerate(lines):
        centre = 0.5 * (pairs.first[i] + pairs.second[i])
        for k, a in enumerate(approaches[i]):
            if a @ down >= BELOW:
                for closing in (line, -line):
                    yield AntipodalGrasp(
                        centre, closing, a, widths[i], float(extents[i]) if k == 0 else 0.0,
                        float(contact[i]), float(pairs.normal_angle[i]),
                    )  # fmt: skip


def grasp_candidates(
    grasps: Sequence[AntipodalGrasp], hand: Hand, solids: Sequence[Solid], clear: bool
) -> GraspCandidates:
    """Set the depth of the tool in each grasp; drop grasps without a feasible depth.

    The preferred depth is `GRIP_DEPTH`. The palm has to stay clear of the object, the fingertips
    above the support surface, and the fingers have to overlap the contacts. On round sides the
    normals at the contacts stay inside the friction cone.

    Args:
        grasps: One or more grasps.
        hand: The gripper.
        solids: All solids of the object.
        clear: Whether the object's geometry ensures that the fingers touch it at the contacts only.
    """
    centre, closing, approach = (np.array(c) for c in list(zip(*grasps, strict=True))[:3])
    width, extent, contact, angle, radius, part = np.array([grasp[3:] for grasp in grasps]).T
    along = np.einsum("ij,ij->i", approach, centre)
    above = _support(solids, -approach, part) + along
    below = _support(solids, approach, part) - along
    # Distances of the tool centre point from the contacts, against the approach.
    preferred = np.maximum(extent - GRIP_DEPTH, 0.0)
    palm_free = np.maximum(preferred, above + _PALM_CLEARANCE - hand.palm)
    better, enough = (np.maximum(palm_free, hand.tip + c - below) for c in _TIP_CLEARANCE)
    max_off_centre = min(_MAX_OFF_CENTRE, math.sin(friction_cone(solids)))
    overhang = np.where(radius > 0.0, -max_off_centre * radius, _TIP_OVERHANG)
    largest = extent + hand.tip - np.where(extent > 0.0, _MIN_OVERLAP, overhang)
    back = np.minimum(better, largest)
    # Round sides: the tips end short of the widest point, where the normals are inclined.
    off_centre = np.clip((back - hand.tip) / np.maximum(radius, 1e-9), 0.0, max_off_centre)
    angle = np.where(radius > 0.0, np.arcsin(off_centre), angle)
    margin = CLOSING_MARGIN + hand.pad * np.tan(angle)
    depth_loss = (back - preferred) / max(hand.tip + hand.palm, 1e-3)
    costs = {
        "contact": CONTACT_WEIGHT * np.clip(1.0 - contact, 0.0, 1.0),
        "angle": ANGLE_WEIGHT * np.clip(angle / _MAX_ANGLE, 0.0, 1.0),
        "slack": SLACK_WEIGHT * np.clip(1.0 - 0.5 * (hand.stroke - width) / _MIN_SLACK, 0.0, 1.0),
        "depth": DEPTH_WEIGHT * np.clip(depth_loss, 0.0, 1.0),
    }
    k = np.flatnonzero(enough <= largest)
    return GraspCandidates(
        hand.rotations(closing, approach)[k],
        (centre - back[:, None] * approach - hand.offset(width)[:, None] * closing)[k],
        width[k],
        hand.opening(np.minimum(width + 2.0 * margin, hand.stroke))[k],
        {name: cost[k] for name, cost in costs.items()},
        clear,
        closing=hand.closing,
    )


_PRIMITIVES = {
    "box": box_grasps,
    "cylinder": cylinder_grasps,
    "capsule": cylinder_grasps,
    "sphere": sphere_grasps,
}


class AntipodalGraspGenerator:
    """Generates the grasp candidates of one object, in any orientation.

    Grasps of boxes, cylinders, capsules and spheres are computed from their dimensions, for objects
    of up to `MAX_PRIMITIVES` solids. For other objects antipodal pairs are sampled, once.

    Args:
        rng: Random generator for surface points.

    Attributes:
        name: Name of the object, for messages.
        solids: Its convex solids.
        hand: The gripper.
        com: Its centre of mass, in its frame [m].  # (3,)
    """

    def __init__(
        self,
        name: str,
        solids: Sequence[Solid],
        hand: Hand,
        com: np.ndarray,
        rng: np.random.Generator,
    ) -> None:
        self.name, self.solids, self.hand, self.com = name, list(solids), hand, np.array(com)
        few = len(self.solids) <= MAX_PRIMITIVES
        self._primitives = [
            (i, s) for i, s in enumerate(self.solids) if few and s.kind in _PRIMITIVES
        ]
        all_primitive = len(self._primitives) == len(self.solids)
        self._single = all_primitive and len(self.solids) == 1
        self._sampled = (
            None if all_primitive else best_antipodal_pairs(self.solids, hand, self.com, rng)
        )

    def candidates(self, down: np.ndarray) -> GraspCandidates:
        """Return all grasps except those that approach from below.

        Args:
            down: Straight down in the object's frame; unit.  # (3,)

        Raises:
            MotionError: If the gripper cannot grip the object; the message has the reason.
        """
        grasps: list[AntipodalGrasp] = []
        if self._sampled is not None:
            grasps += sampled_grasps(self.solids, *self._sampled, down)
        for i, solid in self._primitives:
            listed = _PRIMITIVES[solid.kind](solid, self.hand, down)
            grasps += [grasp._replace(part=i) for grasp in listed]
        if not grasps:
            raise MotionError(self._no_fit(), reason="grasp")
        found = grasp_candidates(grasps, self.hand, self.solids, self._single)
        if not len(found):
            raise MotionError(
                f"'{self.name}' cannot be gripped deep enough: the fingers extend "
                f"{1e3 * (self.hand.tip + self.hand.palm):.0f} mm beyond the palm",
                reason="grasp",
            )
        solid = self.solids[0]
        if not self._single or solid.kind == "box":
            return found
        axis = down if solid.kind == "sphere" else solid.T_os.rotation[:, 2]
        shape = (len(found), 3)
        return replace(
            found,
            free_axis=np.broadcast_to(axis, shape),
            pivot=np.broadcast_to(solid.T_os.translation, shape),
        )

    def _no_fit(self) -> str:
        width, hand = least_width(self.solids), self.hand
        stroke = f"the fingers open to {1e3 * hand.stroke:.4g} mm"
        if _fits(width, hand):
            friction = f"a friction coefficient of {contact_friction(self.solids):.3g}"
            return f"'{self.name}' has no antipodal pair of contact points at {friction}; {stroke}"
        wide = f"'{self.name}' is at least {1e3 * width:.4g} mm wide; {stroke}"
        needed = width + 2.0 * FINGER_CLEARANCE
        if width <= hand.stroke < needed:
            return f"{wide} and need {1e3 * needed:.4g} mm, with clearance on both sides"
        return wide if width > hand.stroke else f"{wide} and close to {1e3 * hand.least:.4g} mm"


def _support(solids: Sequence[Solid], directions: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Return the support function of the gripped part or of the whole object [m]."""
    each = np.array([solid.support(directions) for solid in solids])  # (solids, n)
    whole = each.max(axis=0)
    own = each[np.maximum(part, 0).astype(int), np.arange(len(part))]
    return np.where(part < 0, whole, own)


def _fits(width: float, hand: Hand) -> bool:
    """Return whether a width [m] is inside the gripper's range of openings."""
    return hand.least + 5e-4 < width <= hand.stroke - 2.0 * FINGER_CLEARANCE


def _orthogonal(line: np.ndarray, down: np.ndarray, turns: Sequence[float]) -> list[np.ndarray]:
    """List unit directions orthogonal to a line: the one nearest to down, turned about the line."""
    first = down - (down @ line) * line
    length = float(np.linalg.norm(first))
    if length < 1e-3:  # a vertical line: any direction orthogonal to it
        first = np.cross(line, np.eye(3)[int(np.argmin(np.abs(line)))])
        length = float(np.linalg.norm(first))
    first = first / length
    second = np.cross(line, first)
    return [np.cos(t) * first + np.sin(t) * second for t in turns]
