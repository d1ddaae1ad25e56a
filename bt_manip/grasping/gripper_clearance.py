"""Distance between the open gripper and its surroundings at a tool pose."""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import Cell, body_poses, entity_of, geom_pose
from bt_manip.collision import moved_bodies
from bt_manip.robots import Robot

SUFFICIENT_CLEARANCE = 4e-3
"""Clearance that the gripper needs on its approach [m]: twice the arm's position error."""

MAX_PENETRATION = 3e-3
"""Accepted penetration of the gripper [m], as its collision shapes are slightly too thick."""

_MAX_DISTANCE = 0.1  # [m] largest measured distance
_MAX_LIFT_DISTANCE = 0.02  # [m] largest measured distance of a lifted object
_MIN_QUERY = 1e-3  # [m] smallest distance limit of MuJoCo's queries


class Clearance(NamedTuple):
    """Smallest distance to other entities."""

    distance: float
    """Signed distance to the nearest entity, negative in penetration [m]."""
    entity: str
    """Name of this entity; empty without one nearby."""


class GripperClearance:
    """Measures the distance of the open gripper to other entities at any tool pose.

    The gripper consists of all bodies that move with the tool. No configuration of the arm is
    needed, so that many poses can be compared; whether the arm can reach them is checked by inverse
    kinematics and `CollisionWorld`. Other robots are ignored: motions are planned around them.

    Args:
        cell: The cell.
        robot: The robot with the gripper.
        ignored: Names of entities that are no obstacles, such as the object to grip.

    Attributes:
        geom_poses: Pose of each gripper geom in the tool frame at the present opening; it depends
            on the compiled model only.
    """

    def __init__(self, cell: Cell, robot: Robot, ignored: Sequence[str]) -> None:
        model = cell.model
        self._cell, self._model, self._data = cell, model, mujoco.MjData(model)
        self._robot = robot
        mount = model.site_bodyid[robot.tool_site_id]
        moved = moved_bodies(model, model.body_dofadr[model.body_weldid[mount]])
        own = model.body_rootid == model.body_rootid[mount]
        collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
        self._hand = np.flatnonzero(collides & moved[model.geom_bodyid]).tolist()
        others = np.flatnonzero(collides & ~own[model.geom_bodyid])
        names = [entity_of(model.body(body).name) for body in range(model.nbody)]
        self._entity_of = {int(g): names[model.geom_bodyid[g]] for g in others}
        self.ignore(ignored)
        self.refresh()

    def ignore(self, names: Sequence[str]) -> None:
        """Set the entities that are no obstacles, besides robots."""
        entities = self._cell.entities.items()
        ignored = {name for name, entity in entities if isinstance(entity, Robot)}.union(names)
        self._obstacles = np.array(
            [geom for geom, name in self._entity_of.items() if name not in ignored], dtype=int
        )

    def refresh(self) -> None:
        """Copy the present state of the cell; the compiled model must be the same."""
        data, source = self._data, self._cell.data
        data.qpos[:] = source.qpos
        data.mocap_pos[:], data.mocap_quat[:] = source.mocap_pos, source.mocap_quat
        mujoco.mj_kinematics(self._model, data)
        self.open()

    def open(self, opening: float = 1.0) -> None:
        """Set the opening of the gripper: 1 for fully open, 0 for closed."""
        model, robot, qpos = self._model, self._robot, self._model.qpos0.copy()
        if robot.gripper is not None:
            robot.gripper.set_opening(qpos, opening)
        site = robot.tool_site_id
        mount = int(model.site_bodyid[site])
        poses = body_poses(model, int(model.body_weldid[mount]), qpos)
        T_tool = poses[mount] * spatial.pose(model.site_pos[site], model.site_quat[site])
        self.geom_poses = {
            geom: T_tool.actInv(geom_pose(model, poses, geom)) for geom in self._hand
        }

    def at_pose(self, T_wt: pin.SE3) -> Clearance:
        """Measure the clearance of the gripper at a tool pose."""
        self._move_gripper(T_wt)
        return self._nearest(self._hand, self._obstacles, _MAX_DISTANCE)

    def to_entity(self, name: str, T_wt: pin.SE3) -> float:
        """Measure the distance of the gripper at a tool pose to one entity [m]."""
        self._move_gripper(T_wt)
        return self._nearest(self._hand, self._geoms_of(name), _MAX_DISTANCE).distance

    def of_displaced(self, name: str, displacements: Sequence[np.ndarray]) -> Clearance:
        """Measure the smallest clearance of an entity at displacements from its present pose.

        Args:
            name: The entity.
            displacements: Translations in the world [m].  # (3,) each
        """
        data, own = self._data, self._geoms_of(name)
        others = self._obstacles[~np.isin(self._obstacles, own)]
        start = data.geom_xpos[own].copy()
        best = Clearance(_MAX_DISTANCE, "")
        for displacement in displacements:
            data.geom_xpos[own] = start + displacement
            best = min(best, self._nearest(own.tolist(), others, _MAX_LIFT_DISTANCE))
        data.geom_xpos[own] = start
        return best

    def _geoms_of(self, name: str) -> np.ndarray:
        """List the collision geoms of an entity."""  # (n,)
        return np.array([g for g, entity in self._entity_of.items() if entity == name], dtype=int)

    def _move_gripper(self, T_wt: pin.SE3) -> None:
        data = self._data
        for geom, T_tg in self.geom_poses.items():
            T_wg = T_wt * T_tg
            data.geom_xpos[geom] = T_wg.translation
            data.geom_xmat[geom] = T_wg.rotation.ravel()

    def _nearest(self, geoms: Sequence[int], others: np.ndarray, limit: float) -> Clearance:
        model, data, best = self._model, self._data, Clearance(limit, "")
        gaps = self._sphere_gaps(np.array(geoms, dtype=int), others)
        for i, k in np.argwhere(gaps < limit).tolist():
            if gaps[i, k] >= best.distance:
                continue
            other = int(others[k])
            reach = max(best.distance, _MIN_QUERY)
            distance = mujoco.mj_geomDistance(model, data, int(geoms[i]), other, reach, None)
            if distance < best.distance:
                best = Clearance(float(distance), self._entity_of[other])
        return best

    def _sphere_gaps(self, geoms: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return the distances of bounding spheres [m]; -inf for planes."""
        model, position = self._model, self._data.geom_xpos
        offset = position[others] - position[geoms][:, np.newaxis]
        radii = model.geom_rbound[others] + model.geom_rbound[geoms][:, np.newaxis]
        gaps = np.sqrt((offset * offset).sum(axis=-1)) - radii
        gaps[:, model.geom_type[others] == int(mujoco.mjtGeom.mjGEOM_PLANE)] = -np.inf
        return np.asarray(gaps)  # (len(geoms), len(others))


def with_clearance(
    poses: Sequence[pin.SE3], gripper_clearance: GripperClearance
) -> tuple[list[pin.SE3], Clearance]:
    """Select the tool poses with sufficient clearance.

    Args:
        poses: Tool poses.
        gripper_clearance: Measures their clearance.

    Returns:
        The poses with sufficient clearance, or else the pose with the largest; and the largest
        clearance.
    """
    measured = [gripper_clearance.at_pose(T) for T in poses]
    largest = max(measured, key=lambda clearance: clearance.distance)
    free = [T for T, c in zip(poses, measured, strict=True) if c.distance >= SUFFICIENT_CLEARANCE]
    return free or [poses[measured.index(largest)]], largest
