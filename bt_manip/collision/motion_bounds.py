"""Upper bounds of the displacement of an arm's links between configurations."""

from functools import cache

import mujoco
import numpy as np

_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


def link_of_body(model: mujoco.MjModel, joints: np.ndarray) -> np.ndarray | None:
    """Return the link of each body: the number of the arm's joints that move it.

    Args:
        model: The compiled model.
        joints: Ids of the arm's joints, from the base on.  # (nq,)

    Returns:
        0 for bodies that no joint moves; None if the joints are not a chain of hinges.
        # (nbody,)
    """
    link = np.zeros(model.nbody, dtype=int)
    bodies = model.jnt_bodyid[joints].tolist()
    for body in range(1, model.nbody):  # a parent always comes before its children
        link[body] = link[model.body_parentid[body]]
        while link[body] < len(bodies) and bodies[link[body]] == body:
            link[body] += 1
    is_chain = bool(link.max() == len(bodies)) and bool((np.diff(link[bodies]) > 0).all())
    return link if is_chain and (model.jnt_type[joints] == _HINGE).all() else None


Frames = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Joint axes and anchors, and positions and orientations of bodies, at configurations."""


class MotionBounds:
    """Bounds the displacement of all points of an arm, with links enclosed in spheres.

    If the joints move by dq along a straight segment, the displacement of a point x is at most the
    norm of its first-order displacement J dq, plus half of the largest second derivative along the
    segment: the sum of |axis_j x (axis_k x (x - p_k))| |dq_j| |dq_k|, with k the joint nearer to
    the tip. The distance of x from p_k is at most that along the links.

    Args:
        model: The compiled model.
        data: Kinematics at any configuration.
        joints: Ids of the arm's joints, from the base on.  # (nq,)
        link_of_geom: Link of each geom to enclose; 0 for all others.  # (ngeom,)
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        joints: np.ndarray,
        link_of_geom: np.ndarray,
    ) -> None:
        self._joints, nq = joints, len(joints)
        self._bodies = model.jnt_bodyid[joints]
        anchors = data.xanchor[joints]
        centres, self._radii = anchors.copy(), np.zeros(nq)
        position, radius = data.geom_xpos, model.geom_rbound
        lowest, highest = position - radius[:, np.newaxis], position + radius[:, np.newaxis]
        geoms = np.argsort(link_of_geom, kind="stable")
        geoms = geoms[link_of_geom[geoms] > 0]
        link = link_of_geom[geoms] - 1
        links, first = np.unique(link, return_index=True)
        if len(links):
            low = np.minimum.reduceat(lowest[geoms], first)
            centres[links] = 0.5 * (low + np.maximum.reduceat(highest[geoms], first))
            reach = norms(position[geoms] - centres[link]) + radius[geoms]
            self._radii[links] = np.maximum.reduceat(reach, first)
        rotations = data.xmat[self._bodies].reshape(-1, 3, 3)
        self._local = np.einsum("kji,kj->ki", rotations, centres - data.xpos[self._bodies])
        along = np.concatenate([[0.0], np.cumsum(norms(anchors[1:] - anchors[:-1]))])
        outermost = norms(centres - anchors) + self._radii
        self._moves, between, outer = _joint_order(nq)
        levers = np.where(self._moves, along - along[:, np.newaxis] + outermost, 0.0)
        self._relative = (between * levers[:, np.newaxis]).reshape(nq, nq * nq)
        self._second = 0.5 * levers[outer].reshape(nq * nq, nq)

    def frames(self, data: mujoco.MjData) -> Frames:
        """Return a copy of the arm's frames, for `displacement`."""
        bodies, joints = self._bodies, self._joints
        return data.xaxis[joints], data.xanchor[joints], data.xpos[bodies], data.xmat[bodies]

    def displacement(self, frames: list[Frames], dq: np.ndarray) -> np.ndarray:
        """Return an upper bound of the displacement of each link's points in the world [m].

        Args:
            frames: `frames` of the m start configurations.
            dq: Joint displacements, w for each configuration [rad].  # (m, w, nq)
        """  # (m, w, nq)
        m, w, nq = dq.shape
        axes, anchors, positions, matrices = map(np.array, zip(*frames, strict=True))
        rotations = matrices.reshape(m, nq, 3, 3)
        centres = positions + (rotations @ self._local[..., None])[..., 0]  # of the spheres
        arms = centres[:, np.newaxis] - anchors[:, :, np.newaxis]
        moves = self._moves[..., np.newaxis]
        axes = np.where(moves, axes[:, :, np.newaxis], 0.0)  # (m, joint, link, 3)
        linear = np.cross(axes, arms).reshape(m, nq, 3 * nq)
        translation = (dq @ linear).reshape(m, w, nq, 3)
        rotation = (dq @ axes.reshape(m, nq, 3 * nq)).reshape(m, w, nq, 3)
        size = np.abs(dq)
        products = (size[..., np.newaxis] * size[..., np.newaxis, :]).reshape(m, w, nq * nq)
        return norms(translation) + self._radii * norms(rotation) + products @ self._second

    def relative_displacement(self, dq: np.ndarray) -> np.ndarray:
        """Return an upper bound of each link's displacement relative to each previous link [m].

        Each joint between the two links displaces a point by at most its angle times the largest
        distance of the point from its axis.

        Args:
            dq: Largest absolute joint displacements [rad].  # (m, nq)

        Returns:
            Indexed by the link of the frame, then by the link of the points.  # (m, nq, nq)
        """
        nq = len(self._joints)
        return (dq @ self._relative).reshape(-1, nq, nq)


@cache
def _joint_order(nq: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the order of joints and links in a chain.

    Returns:
        Whether a joint moves a link (joint, link); whether it is between two links (joint, link
        before, link); the outer one of two joints.  # (nq, nq), (nq, nq, nq), (nq, nq)
    """
    joint, before, link = np.ogrid[:nq, :nq, :nq]
    outer = np.maximum(*np.ogrid[:nq, :nq])
    return (joint <= link)[:, 0], (before < joint) & (joint <= link), outer


def norms(vectors: np.ndarray) -> np.ndarray:
    """Return the norms of vectors along the last axis."""
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
