"""Pairs of geoms on adjacent links that never collide at any angle of the joint between them."""

from collections import deque
from collections.abc import Mapping

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import body_poses, geom_pose

from .collision_model import pair_margins

QUERY_ERROR = 2e-5  # [m] error of distance queries
MAX_JOINT_INTERVALS = 8000  # maximum number of intervals of a joint's range
_QUERY_RANGE = 1.0  # [m] largest measured distance
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)
_BOX_CORNERS = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T

_results: dict[bytes, bool] = {}  # by `_AdjacentPair.key`: robots are compiled many times


def never_colliding_pairs(
    model: mujoco.MjModel, joints: np.ndarray, link: np.ndarray, pairs: np.ndarray
) -> np.ndarray:
    """Return the mask of geom pairs on adjacent links that never collide.

    The distance of such a pair depends on one joint angle. From an angle with a known distance, the
    joint can rotate by this distance over the largest lever of a point of the outer geom before the
    geoms can touch. The range is bisected until these rotations cover all intervals.

    Args:
        model: The compiled model.
        joints: Ids of the arm's joints, which are hinges, from the base on.  # (nq,)
        link: Link of each geom: the number of joints that move it.  # (ngeom,)
        pairs: Mask of the pairs to examine.  # (ngeom, ngeom)
    """  # (ngeom, ngeom)
    weld, body = model.body_weldid, model.jnt_bodyid[joints]
    links = np.concatenate([[weld[model.body_parentid[body[0]]]], weld[body]])
    rigid = weld[model.geom_bodyid] == links[link]  # not moved by the gripper
    rigid &= model.body_rootid[model.geom_bodyid] == model.body_rootid[body[0]]
    adjacent = pairs & rigid & rigid[:, np.newaxis] & (link[:, np.newaxis] + 1 == link)
    data, least = mujoco.MjData(model), pair_margins(model) + QUERY_ERROR
    found = np.zeros_like(pairs)
    # In the frame of the robot's root, so that results do not depend on the robot's pose.
    poses = body_poses(model, int(model.body_rootid[body[0]]), model.qpos0)
    for inner, outer in np.argwhere(adjacent).tolist():
        pair = _AdjacentPair(
            model, data, poses, int(joints[link[inner]]), inner, outer, least[inner, outer]
        )
        key = pair.key()
        if key not in _results:
            _results[key] = pair.never_collides()
        found[inner, outer] = found[outer, inner] = _results[key]
    return found


class _AdjacentPair:
    """Two geoms with one joint between them."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        poses: Mapping[int, pin.SE3],
        joint: int,
        inner: int,
        outer: int,
        least: float,
    ) -> None:
        self._model, self._data = model, data
        self._geoms, self._least = (inner, outer), float(least)
        self._q0 = float(model.qpos0[model.jnt_qposadr[joint]])
        lower, upper = model.jnt_range[joint] if model.jnt_limited[joint] else (-np.pi, np.pi)
        self._range = float(lower), float(min(upper, lower + 2.0 * np.pi))
        self._T_inner, self._T_outer = (geom_pose(model, poses, geom) for geom in self._geoms)
        T_body = poses[int(model.jnt_bodyid[joint])]
        self._axis = T_body.rotation @ model.jnt_axis[joint]
        self._anchor = T_body.act(np.array(model.jnt_pos[joint]))

    def key(self) -> bytes:
        """Return all inputs of the result, as a key."""
        model = self._model
        poses = [T.homogeneous for T in (self._T_inner, self._T_outer)]
        numbers = np.array([self._q0, *self._range, self._least])
        parts = [*poses, self._axis, self._anchor, numbers]
        for geom in self._geoms:
            parts += [model.geom_type[geom], model.geom_size[geom], hull_points(model, geom)]
        return b"".join(part.tobytes() for part in parts)

    def never_collides(self) -> bool:
        """Return whether the geoms do not touch in the whole range of the joint."""
        lever = self._lever()
        _place(self._data, self._geoms[0], self._T_inner)
        ends = [(angle, self._clearance(angle)) for angle in self._range]
        intervals = deque([(ends[0], ends[1])])
        for _ in range(MAX_JOINT_INTERVALS):
            if not intervals:
                return True
            first, last = intervals.popleft()
            if min(first[1], last[1]) <= 0.0:
                return False
            if first[1] + last[1] < lever * (last[0] - first[0]):
                angle = 0.5 * (first[0] + last[0])
                middle = angle, self._clearance(angle)
                intervals += [(first, middle), (middle, last)]
        return False

    def _clearance(self, angle: float) -> float:
        """Return the distance at a joint angle [rad] minus the required one [m]."""
        rotation = pin.AngleAxis(angle - self._q0, self._axis).matrix()
        turned = pin.SE3(rotation, self._anchor - rotation @ self._anchor) * self._T_outer
        _place(self._data, self._geoms[1], turned)
        distance = mujoco.mj_geomDistance(self._model, self._data, *self._geoms, _QUERY_RANGE, None)
        return float(distance) - self._least

    def _lever(self) -> float:
        """Return the largest distance of the outer geom's points from the joint axis [m]."""
        T, points = self._T_outer, hull_points(self._model, self._geoms[1])
        offsets = points @ T.rotation.T + T.translation - self._anchor
        return float(np.linalg.norm(np.cross(offsets, self._axis), axis=1).max())


def _place(data: mujoco.MjData, geom: int, T: pin.SE3) -> None:
    data.geom_xpos[geom], data.geom_xmat[geom] = T.translation, T.rotation.ravel()


def hull_points(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """Return points in a geom's frame whose convex hull contains the geom [m]."""  # (n, 3)
    if model.geom_type[geom] == _MESH:
        mesh = model.geom_dataid[geom]
        start = model.mesh_vertadr[mesh]
        return np.asarray(model.mesh_vert[start : start + model.mesh_vertnum[mesh]])
    return np.asarray(model.geom_aabb[geom, :3] + _BOX_CORNERS * model.geom_aabb[geom, 3:])
