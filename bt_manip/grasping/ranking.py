"""Which grasps are better than others, and why."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from .grasp import Grasp, GraspTable
from .hand import Hand

ALIKE = 0.03
"""Grasps whose costs differ by less serve equally well: the arm takes what it is nearer to."""

_WEIGHTS = (1.0, 0.5, 0.3, 1.0, 0.3, 0.5)  # in the order of `Cost`
_ASIDE = 10.0  # [rad/m] that moving aside counts, beside turning
_STILL = 0.3  # [rad] that costs count, where the way to a grasp counts more
_LEVER = 0.05  # [m] beside the centre of mass at which balance costs all of its weight
_TIGHT = 5e-3  # [m] on each side below which the fingers have little slack


class Cost(NamedTuple):
    """What speaks against a grasp, each from 0, and at most its weight; the parts add up."""

    tilt: float
    """How far from straight down the tool comes in."""
    balance: float
    """How far beside the line through the fingers the centre of mass hangs."""
    contact: float
    """How little of the pads lies on something."""
    slant: float
    """How near to slipping off the faces the fingers press."""
    slack: float
    """How little wider than the object the fingers open."""
    depth: float
    """How much farther out than it would like to be the hand is kept."""

    @property
    def total(self) -> float:
        """All of it."""
        return sum(self)

    def __str__(self) -> str:
        """Name what costs anything, the most costly first."""
        parts = sorted(self._asdict().items(), key=lambda item: -item[1])
        return ", ".join(f"{name} {cost:.2f}" for name, cost in parts if cost >= 0.005) or "nothing"


class Ranked(NamedTuple):
    """A grasp with what it costs, where the tool is in the world then."""

    grasp: Grasp
    T_wt: pin.SE3
    cost: Cost
    away: float
    """How far the tool has to turn and to move aside before it can go straight there [rad]."""


class Ranking:
    """Grasps of one object as it lies now, compared by what needs no arm to be moved."""

    def __init__(
        self, grasps: GraspTable, T_wo: pin.SE3, centre: np.ndarray, hand: Hand, T_now: pin.SE3
    ) -> None:
        """Compare grasps.

        Args:
            grasps: Grasps of the object.
            T_wo: Its pose.
            centre: Its centre of mass, in its frame [m].  # (3,)
            hand: The hand.
            T_now: Where the tool is.
        """
        self._grasps, self._T_wo = grasps, T_wo
        R = T_wo.rotation @ grasps.rotation
        place = grasps.position @ T_wo.rotation.T + T_wo.translation
        lever = np.linalg.norm((T_wo.act(centre) - place)[:, :2], axis=1)
        shares = [
            np.arccos(np.clip(-R[:, 2, 2], -1.0, 1.0)) / (0.5 * math.pi),
            lever / _LEVER,
            1.0 - grasps.contact,
            grasps.slant / (0.25 * math.pi),
            1.0 - 0.5 * (hand.stroke - grasps.width) / _TIGHT,
            grasps.deeper / max(hand.tip + hand.palm, 1e-3),
        ]
        self._costs = np.clip(np.stack(shares, axis=1), 0.0, 1.0) * Cost(*_WEIGHTS)
        self._total = self._costs.sum(axis=1)
        cosine = 0.5 * (np.einsum("nij,ij->n", R, T_now.rotation) - 1.0)
        self._turn = np.arccos(np.clip(cosine, -1.0, 1.0))
        offset, approach = T_now.translation - place, R[:, :, 2]
        on_axis = np.einsum("ij,ij->i", offset, approach)[:, None] * approach
        self._away = self._turn + _ASIDE * np.linalg.norm(offset - on_axis, axis=1)

    def best_first(self) -> Iterator[Ranked]:
        """Give the grasps by their costs; of those that are alike the one to turn least for."""
        order = np.argsort(self._total, kind="stable")
        sorted_total = self._total[order]
        first = 0
        while first < len(order):
            last = int(np.searchsorted(sorted_total, sorted_total[first] + ALIKE))
            tier = order[first : max(last, first + 1)]
            for i in tier[np.argsort(self._turn[tier], kind="stable")]:
                yield self._ranked(int(i))
            first += len(tier)

    def nearest_first(self) -> Iterator[Ranked]:
        """Give the grasps by how far the tool has to turn and to move aside for them."""
        for i in np.argsort(self._away + _STILL * self._total, kind="stable"):
            yield self._ranked(int(i))

    def _ranked(self, i: int) -> Ranked:
        grasp = self._grasps[i]
        return Ranked(
            grasp, self._T_wo * grasp.T_ot, Cost(*self._costs[i].tolist()), float(self._away[i])
        )
