"""Bounding boxes of entities, distances between entities, and poses inside an entity."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial

from .exceptions import CellError
from .objects.bounds import geom_box

if TYPE_CHECKING:
    from .cell import Cell


def extent(cell: "Cell", name: str, T_wf: pin.SE3 | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounding box of an entity's collision geometry, along the axes of a frame [m].

    Args:
        cell: The cell.
        name: The entity; only its collision geoms count.
        T_wf: The frame; default: the world.

    Returns:
        Its lower and upper corner.  # 2 x (3,)

    Raises:
        CellError: If there is no such entity, or it has no collision geometry.
    """
    lower, upper = geom_boxes(cell, name, T_wf)
    return lower.min(axis=0), upper.max(axis=0)


def geom_boxes(
    cell: "Cell", name: str, T_wf: pin.SE3 | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounding boxes of an entity's collision geoms, as `extent` does that of all."""
    # 2 x (n, 3)
    geoms = collision_geoms(cell, name)
    if not len(geoms):
        raise CellError(f"'{name}' has no collision geometry")
    boxes = [geom_box(cell.model, cell.data, int(geom), T_wf) for geom in geoms]
    lower, upper = zip(*boxes, strict=True)
    return np.array(lower), np.array(upper)


def collision_geoms(cell: "Cell", name: str) -> np.ndarray:
    """Return the ids of an entity's collision geoms.

    Raises:
        CellError: If there is no such entity.
    """  # (n,)
    model = cell.model
    cell.find(name)
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    return np.flatnonzero(cell.contacts.geoms(name) & collides)


def body_poses(model: mujoco.MjModel, root: int, qpos: np.ndarray) -> dict[int, pin.SE3]:
    """Return the poses of a body and its descendants, in the frame of this body.

    They are composed from the compiled model, so that they do not depend on the body's pose.

    Args:
        model: The compiled model.
        root: Id of the body.
        qpos: Positions of all joints; only joints of descendants are read.

    Returns:
        The poses by body id, the root first.
    """
    poses = {root: pin.SE3.Identity()}
    for body, parent in enumerate(model.body_parentid.tolist()):
        if parent in poses:  # a parent always comes before its children
            T = poses[parent] * spatial.pose(model.body_pos[body], model.body_quat[body])
            first = int(model.body_jntadr[body])
            for joint in range(first, first + int(model.body_jntnum[body])):
                T = T * _joint_displacement(model, joint, qpos)
            poses[body] = T
    return poses


def _joint_displacement(model: mujoco.MjModel, joint: int, qpos: np.ndarray) -> pin.SE3:
    """Return the displacement of a body by one joint, in the body's frame."""
    kind, adr = int(model.jnt_type[joint]), int(model.jnt_qposadr[joint])
    axis, anchor = model.jnt_axis[joint], model.jnt_pos[joint]
    if kind == int(mujoco.mjtJoint.mjJNT_SLIDE):
        return pin.SE3(np.eye(3), axis * (qpos[adr] - model.qpos0[adr]))
    if kind == int(mujoco.mjtJoint.mjJNT_HINGE):
        rotation = pin.AngleAxis(float(qpos[adr] - model.qpos0[adr]), np.array(axis)).matrix()
    else:  # a ball joint; free joints are only at the root of an entity
        rotation = spatial.pose(np.zeros(3), qpos[adr : adr + 4]).rotation
    return pin.SE3(rotation, anchor - rotation @ anchor)


def geom_pose(model: mujoco.MjModel, poses: Mapping[int, pin.SE3], geom: int) -> pin.SE3:
    """Return the pose of a geom, given the poses of bodies."""
    T_bg = spatial.pose(model.geom_pos[geom], model.geom_quat[geom])
    return poses[int(model.geom_bodyid[geom])] * T_bg


def centre_of_mass(cell: "Cell", name: str) -> np.ndarray:
    """Return the centre of mass of an entity without overrides, in its frame [m].

    Raises:
        CellError: If there is no such entity.
    """  # (3,)
    model = cell.nominal_model
    poses = body_poses(model, cell.body_id(name), cell.data.qpos)
    masses = model.body_mass[list(poses)]
    centres = np.array([T.act(np.array(model.body_ipos[body])) for body, T in poses.items()])
    total = float(masses.sum())
    return np.asarray(masses @ centres / total if total > 0.0 else centres[0])


def nearest_free(cell: "Cell", name: str, within: float) -> float:
    """Return the distance from an entity to the nearest other free object [m].

    Args:
        cell: The cell.
        name: The entity.
        within: Upper bound of the result [m].

    Raises:
        CellError: If there is no such entity.
    """
    mine = collision_geoms(cell, name)
    nearest = within
    for other in cell.objects:
        if other == name or not cell.is_free(other):
            continue
        for a in mine:
            for b in collision_geoms(cell, other):
                distance = mujoco.mj_geomDistance(
                    cell.model, cell.data, int(a), int(b), within, None
                )
                nearest = min(nearest, float(distance))
    return nearest
