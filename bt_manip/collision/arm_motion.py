"""How far the parts of an arm move, at the most, from one configuration to others."""

from functools import cache
from typing import NamedTuple

import mujoco
import numpy as np

_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


def part_of_body(model: mujoco.MjModel, joints: np.ndarray) -> np.ndarray | None:
    """Number the bodies by how many of an arm's joints move them.

    Args:
        model: What the arm is in.
        joints: Ids of its joints, from the base on.  # (nq,)

    Returns:
        0 for what none moves; None where one joint does not follow the other, or one does not turn.
        # (nbody,)
    """
    part = np.zeros(model.nbody, dtype=int)
    bodies = model.jnt_bodyid[joints].tolist()
    for body in range(1, model.nbody):  # a parent always comes before its children
        part[body] = part[model.body_parentid[body]]
        while part[body] < len(bodies) and bodies[part[body]] == body:
            part[body] += 1
    in_a_row = bool(part.max() == len(bodies)) and bool((np.diff(part[bodies]) > 0).all())
    return part if in_a_row and (model.jnt_type[joints] == _HINGE).all() else None


class Stand(NamedTuple):
    """Where an arm's axes and parts are at configurations.

    Attributes:
        axes: Directions of the joints.  # (m, nq, 3)
        anchors: Points on these axes [m].  # (m, nq, 3)
        middles: Of the spheres around the parts [m].  # (m, nq, 3)
    """

    axes: np.ndarray
    anchors: np.ndarray
    middles: np.ndarray


class ArmMotion:
    """Bounds the ways of all points of an arm, each part of which is inside a sphere.

    With x a point that the joints turn by Δ, straight from one configuration to another, x moves by
    no more than the first order, which is Jacobian times Δ, and half of the longest second
    derivative on the way: its parts are ω_j × (ω_k × (x - p_k)) Δ_j Δ_k, with k the joint nearer to
    the tip, and x is never farther from that than along the links.

    Attributes:
        radii: Of the spheres [m].  # (nq,)
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        joints: np.ndarray,
        part_of_geom: np.ndarray,
    ) -> None:
        """Put spheres around the parts.

        Args:
            model: What the arm is in.
            data: Has it at any configuration.
            joints: Ids of its joints, from the base on.  # (nq,)
            part_of_geom: Of those geoms that matter, by how many joints move them; 0 for all
                others.  # (ngeom,)
        """
        self._joints, nq = joints, len(joints)
        self._bodies = model.jnt_bodyid[joints]
        anchors = data.xanchor[joints]
        middles, self.radii = anchors.copy(), np.zeros(nq)
        at, bound = data.geom_xpos, model.geom_rbound
        lowest, highest = at - bound[:, np.newaxis], at + bound[:, np.newaxis]
        for k in range(nq):
            geoms = np.flatnonzero(part_of_geom == k + 1)
            if len(geoms):
                middles[k] = 0.5 * (lowest[geoms].min(axis=0) + highest[geoms].max(axis=0))
                self.radii[k] = (_norm(at[geoms] - middles[k]) + bound[geoms]).max()
        rotations = data.xmat[self._bodies].reshape(-1, 3, 3)
        self._local = np.einsum("kji,kj->ki", rotations, middles - data.xpos[self._bodies])
        along = np.concatenate([[0.0], np.cumsum(_norm(anchors[1:] - anchors[:-1]))])
        outermost = _norm(middles - anchors) + self.radii
        self._moves, between, outer = _order(nq)
        levers = np.where(self._moves, along - along[:, np.newaxis] + outermost, 0.0)
        self._apart = (between * levers[:, np.newaxis]).reshape(nq, nq * nq)
        self._second = 0.5 * levers[outer].reshape(nq * nq, nq)

    def stand(self, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Copy where axes and bodies are, for `stands`."""
        bodies, joints = self._bodies, self._joints
        return data.xaxis[joints], data.xanchor[joints], data.xpos[bodies], data.xmat[bodies]

    def stands(self, copies: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]) -> Stand:
        """Give where axes and spheres are at the configurations that were copied."""
        axes, anchors, positions, matrices = map(np.array, zip(*copies, strict=True))
        rotations = matrices.reshape(*positions.shape, 3)
        return Stand(axes, anchors, positions + (rotations @ self._local[..., None])[..., 0])

    def ways(self, stand: Stand, turned: np.ndarray) -> np.ndarray:
        """Bound the ways of the points of each part [m].

        Args:
            stand: Where they begin, m times.
            turned: By what the joints turn from there on, w times each [rad].  # (m, w, nq)
        """  # (m, w, nq)
        m, w, nq = turned.shape
        arms = stand.middles[:, np.newaxis] - stand.anchors[:, :, np.newaxis]  # (m, joint, part, 3)
        moves = self._moves[..., np.newaxis]
        axes = np.where(moves, stand.axes[:, :, np.newaxis], 0.0)
        linear = np.cross(axes, arms).reshape(m, nq, 3 * nq)
        shifts = (turned @ linear).reshape(m, w, nq, 3)
        turns = (turned @ axes.reshape(m, nq, 3 * nq)).reshape(m, w, nq, 3)
        size = np.abs(turned)
        products = (size[..., np.newaxis] * size[..., np.newaxis, :]).reshape(m, w, nq * nq)
        return _norm(shifts) + self.radii * _norm(turns) + products @ self._second

    def ways_apart(self, turned: np.ndarray) -> np.ndarray:
        """Bound the ways of the points of each part as a part before it sees them [m].

        No joint between the two moves a point farther than by its angle times the longest distance
        from its axis that the point can have, which is along the links.

        Args:
            turned: By how much the joints turn at the most [rad].  # (m, nq)

        Returns:
            The part that sees, the part that moves.  # (m, nq, nq)
        """
        nq = len(self._joints)
        return (turned @ self._apart).reshape(-1, nq, nq)


@cache
def _order(nq: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mark which joint moves which part, and which joint is between which two parts.

    Returns:
        By joint and part; by joint, part before and part; and the outer one of two joints.
        # (nq, nq), (nq, nq, nq), (nq, nq)
    """
    joint, before, part = np.ogrid[:nq, :nq, :nq]
    outer = np.maximum(*np.ogrid[:nq, :nq])
    return (joint <= part)[:, 0], (before < joint) & (joint <= part), outer


def _norm(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
