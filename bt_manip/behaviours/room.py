"""Whether there is room for the hand where it is to grip."""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell
from bt_manip.robots import Robot

from .extent import solid_geoms

ENOUGH = 4e-3
"""Room that a hand needs on its way to a grip [m]: what the arm may be off, twice."""

_FAR = 0.1  # [m] beyond which distances are not measured


class Room(NamedTuple):
    """How near a hand comes to what stands around."""

    distance: float
    """To the nearest, negative inside it [m]."""
    nearest: str
    """Name of that entity; empty when nothing is near."""


class HandRoom:
    """Measures how near the open hand would come to things, at any pose of the tool.

    The hand is all that moves with the tool: what is welded to it, and the open fingers. Other
    robots are left out: they go away again, and motions are planned around them.
    """

    def __init__(self, cell: Cell, robot: Robot, ignored: Sequence[str]) -> None:
        """Look at the cell as it is now.

        Args:
            cell: The cell.
            robot: The robot whose hand it is.
            ignored: Names of entities that the hand may come near to: what it is to grip.
        """
        model = cell.model
        self._model = model
        self._data = data = mujoco.MjData(model)
        data.qpos[:] = cell.data.qpos
        data.mocap_pos[:], data.mocap_quat[:] = cell.data.mocap_pos, cell.data.mocap_quat
        if robot.description.gripper is not None:
            robot.set_opening(data.qpos, robot.gripper_travel.open_width)
        mujoco.mj_kinematics(model, data)
        site = robot.tool_site_id
        T_wt = pin.SE3(data.site_xmat[site].reshape(3, 3).copy(), data.site_xpos[site].copy())
        self._hand = _hand_geoms(model, robot)
        own = np.isin(model.geom_bodyid, _bodies_of(model, robot))
        self._label = {}
        others = []
        for name in cell.entities:
            if name not in ignored and not isinstance(cell.entities[name], Robot):
                for geom in solid_geoms(cell, name):
                    if not own[geom]:
                        self._label[int(geom)] = name
                        others.append(int(geom))
        self._others = np.array(others, dtype=int)
        tool = T_wt.inverse()
        self._T_tg = [
            tool * pin.SE3(data.geom_xmat[g].reshape(3, 3).copy(), data.geom_xpos[g].copy())
            for g in self._hand
        ]

    def at(self, T_wt: pin.SE3) -> Room:
        """Measure at a pose of the tool."""
        model, data = self._model, self._data
        best = Room(_FAR, "")
        for geom, T_tg in zip(self._hand, self._T_tg, strict=True):
            T_wg = T_wt * T_tg
            data.geom_xpos[geom] = T_wg.translation
            data.geom_xmat[geom] = T_wg.rotation.ravel()
            for other in self._near(geom):
                distance = mujoco.mj_geomDistance(model, data, geom, int(other), _FAR, None)
                if distance < best.distance:
                    best = Room(float(distance), self._label[int(other)])
        return best

    def _near(self, geom: int) -> np.ndarray:
        """Choose the geoms whose bounding spheres are near; planes have none."""
        if not len(self._others):
            return self._others
        model, data, others = self._model, self._data, self._others
        offset = data.geom_xpos[others] - data.geom_xpos[geom]
        gap = np.sqrt((offset * offset).sum(axis=1)) - model.geom_rbound[others]
        plane = model.geom_type[others] == int(mujoco.mjtGeom.mjGEOM_PLANE)
        return others[plane | (gap - model.geom_rbound[geom] < _FAR)]


def with_room(poses: Sequence[pin.SE3], room: HandRoom) -> tuple[list[pin.SE3], Room]:
    """Choose the poses at which the hand has enough room.

    Args:
        poses: Poses of the tool.
        room: What measures.

    Returns:
        Those with room, or the roomiest where none has; and the room at the roomiest.
    """
    found = [(room.at(T), i) for i, T in enumerate(poses)]
    most, i = max(found, key=lambda item: item[0].distance)
    free = [poses[k] for there, k in found if there.distance >= ENOUGH]
    return free or [poses[i]], most


def _hand_geoms(model: mujoco.MjModel, robot: Robot) -> list[int]:
    weld = model.body_weldid[model.site_bodyid[robot.tool_site_id]]
    bodies = []
    for body in range(model.nbody):
        ancestor = body
        while ancestor > weld:
            ancestor = model.body_parentid[ancestor]
        if ancestor == weld and weld != 0:
            bodies.append(body)
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    return [int(g) for g in np.flatnonzero(np.isin(model.geom_bodyid, bodies) & solid)]


def _bodies_of(model: mujoco.MjModel, robot: Robot) -> np.ndarray:
    root = model.body_rootid[model.site_bodyid[robot.tool_site_id]]
    return np.flatnonzero(model.body_rootid == root)
