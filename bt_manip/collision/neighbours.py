"""Geoms of an arm that never touch each other, whatever the joint between them does."""

from collections import deque

import mujoco
import numpy as np

from .geom_pairs import margins

SURE = 2e-5  # [m] by which distances may be off
MOST = 8000  # parts of a joint's range that are looked at
_APART = 1.0  # [m] up to which distances are asked for
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)
_CORNERS = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
_ROUND = 9  # digits [m] to which poses are the same

_known: dict[bytes, bool] = {}  # by all that the answer depends on: a robot is compiled many times


def never_touching(
    model: mujoco.MjModel, joints: np.ndarray, part: np.ndarray, pairs: np.ndarray
) -> np.ndarray:
    """Mark pairs of geoms that one joint moves past each other and that never touch.

    Such a pair depends on one angle. From an angle at which its distance is known, the joint may
    turn by that over the longest lever of any point of the outer geom before the two can touch.
    The range is halved until such turns from both ends of each part of it meet.

    Args:
        model: What the arm is in.
        joints: Ids of its joints, which are hinges, from the base on.  # (nq,)
        part: By how many of these each geom is moved.  # (ngeom,)
        pairs: Those that matter.  # (ngeom, ngeom)
    """  # (ngeom, ngeom)
    weld, body = model.body_weldid, model.jnt_bodyid[joints]
    links = np.concatenate([[weld[model.body_parentid[body[0]]]], weld[body]])
    rigid = weld[model.geom_bodyid] == links[part]  # what fingers do is another matter
    rigid &= (part > 0) | (model.body_rootid[model.geom_bodyid] == model.body_rootid[body[0]])
    neighbours = pairs & rigid & rigid[:, np.newaxis] & (part[:, np.newaxis] + 1 == part)
    data, closest = mujoco.MjData(model), margins(model) + SURE
    found = np.zeros_like(pairs)
    for inner, outer in np.argwhere(neighbours).tolist():
        mujoco.mj_kinematics(model, data)
        pair = _Pair(model, data, int(joints[part[inner]]), inner, outer, closest[inner, outer])
        key = pair.key()
        if key not in _known:
            _known[key] = pair.never_touches()
        found[inner, outer] = found[outer, inner] = _known[key]
    return found


class _Pair:
    """Two geoms with one joint between them."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        joint: int,
        inner: int,
        outer: int,
        least: float,
    ) -> None:
        self._model, self._data, self._joint = model, data, joint
        self._geoms, self._least = (inner, outer), float(least)
        lower, upper = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.pi, np.pi)
        self._range = float(lower), float(min(upper, lower + 2.0 * np.pi))
        self._at = data.geom_xpos[outer] - data.xanchor[joint]
        self._rotation = data.geom_xmat[outer].reshape(3, 3)

    def key(self) -> bytes:
        """Give all that the answer depends on, seen from the inner geom."""
        model, data = self._model, self._data
        R = data.geom_xmat[self._geoms[0]].reshape(3, 3)
        from_anchor = data.geom_xpos[self._geoms[0]] - data.xanchor[self._joint]
        seen = (data.xaxis[self._joint], self._at, from_anchor, *self._rotation.T)
        start = data.qpos[model.jnt_qposadr[self._joint]]
        numbers = [(np.array(seen) @ R).ravel(), self._range, (start, self._least)]
        parts = [np.round(np.concatenate(numbers), _ROUND)]
        for geom in self._geoms:
            parts += [model.geom_type[geom], model.geom_size[geom], _corners(model, geom)]
        return b"".join(part.tobytes() for part in parts)

    def never_touches(self) -> bool:
        """Tell whether the two keep apart wherever in its range the joint is."""
        lever = self._lever()
        lower, upper = self._range
        spans = deque([((lower, self._left(lower)), (upper, self._left(upper)))])
        for _ in range(MOST):
            if not spans:
                return True
            (start, before), (end, behind) = spans.popleft()
            if min(before, behind) <= 0.0:
                return False
            if before + behind < lever * (end - start):
                angle = 0.5 * (start + end)
                middle = angle, self._left(angle)
                spans += [((start, before), middle), (middle, (end, behind))]
        return False

    def _left(self, angle: float) -> float:
        """Give how much farther apart than allowed they are at an angle [m]."""
        model, data = self._model, self._data
        adr = model.jnt_qposadr[self._joint]
        before, data.qpos[adr] = float(data.qpos[adr]), angle
        mujoco.mj_kinematics(model, data)
        distance = mujoco.mj_geomDistance(model, data, *self._geoms, _APART, None)
        data.qpos[adr] = before
        return float(distance) - self._least

    def _lever(self) -> float:
        """Give the longest distance of the outer geom's corners from the joint's axis [m]."""
        at = self._at + _corners(self._model, self._geoms[1]) @ self._rotation.T
        beside = np.cross(at, self._data.xaxis[self._joint])
        return float(np.linalg.norm(beside, axis=1).max())


def _corners(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """Give points in a geom's frame whose convex hull it is inside of [m]."""  # (n, 3)
    if model.geom_type[geom] == _MESH:
        mesh = model.geom_dataid[geom]
        start = model.mesh_vertadr[mesh]
        return np.asarray(model.mesh_vert[start : start + model.mesh_vertnum[mesh]])
    return np.asarray(model.geom_aabb[geom, :3] + _CORNERS * model.geom_aabb[geom, 3:])
