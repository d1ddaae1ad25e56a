"""Whether there is room for the hand where it is to grip."""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell
from bt_manip.robots import Robot

from .hand import hand_geoms

ENOUGH = 4e-3
"""Room that a hand needs on its way to a grip [m]: what the arm may be off, twice."""

_FAR = 0.1  # [m] beyond which distances are not measured
_LEAST = 1e-3  # [m] up to which they are measured, whatever is nearer already


class Room(NamedTuple):
    """How near a hand comes to what stands around."""

    distance: float
    """To the nearest, negative inside it [m]."""
    nearest: str
    """Name of that entity; empty when nothing is near."""


class GripperClearance:
    """Measures how near the open hand would come to things, at any pose of the tool.

    The hand is all that moves with the tool: what is welded to it, and the open fingers. No
    configuration of the arm is needed for that, so that many poses can be compared; whether the
    arm can be there too is for inverse kinematics and `CollisionWorld` to say. Other robots are
    left out: they go away again, and motions are planned around them.
    """

    def __init__(
        self, cell: Cell, robot: Robot, ignored: Sequence[str], *, opening: float | None = None
    ) -> None:
        """Look at the cell as it is now.

        Args:
            cell: The cell.
            robot: The robot whose hand it is.
            ignored: Names of entities that the hand may come near to: what it is to grip.
            opening: Of the fingers [m]; by default all the way.
        """
        model = cell.model
        self._model = model
        self._data = data = mujoco.MjData(model)
        data.qpos[:] = cell.data.qpos
        data.mocap_pos[:], data.mocap_quat[:] = cell.data.mocap_pos, cell.data.mocap_quat
        self._robot = robot
        self._hand = hand_geoms(model, robot)
        mujoco.mj_kinematics(model, data)
        site = robot.tool_site_id
        self._T_wt = _pose(data.site_xpos[site], data.site_xmat[site])
        own = model.body_rootid == model.body_rootid[model.site_bodyid[site]]
        solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
        others = np.flatnonzero(solid & ~own[model.geom_bodyid])
        names = [_entity(model, body) for body in range(model.nbody)]
        self._label = labels = {int(g): names[model.geom_bodyid[g]] for g in others}
        robots = {name for name, entity in cell.entities.items() if isinstance(entity, Robot)}
        left_out = robots.union(ignored)
        self._others = np.array([g for g in labels if labels[g] not in left_out], dtype=int)
        self.open(opening)

    def open(self, opening: float | None = None) -> None:
        """Open the fingers to a width [m], by default all the way."""
        robot, data = self._robot, self._data
        if robot.description.gripper is not None:
            widest = robot.gripper_travel.open_width
            robot.set_opening(data.qpos, widest if opening is None else opening)
        site = robot.tool_site_id
        mujoco.mj_kinematics(self._model, data)
        tool = _pose(data.site_xpos[site], data.site_xmat[site]).inverse()
        self.placed = {
            geom: tool * _pose(data.geom_xpos[geom], data.geom_xmat[geom]) for geom in self._hand
        }

    def geoms_of(self, name: str) -> np.ndarray:
        """List the geoms of an entity that can touch."""  # (n,)
        return np.array([g for g, label in self._label.items() if label == name], dtype=int)

    def at(self, T_wt: pin.SE3) -> Room:
        """Measure at a pose of the tool."""
        self._move(self.placed, T_wt)
        return self._nearest(self._hand, self._others, _FAR)

    def to(self, name: str, T_wt: pin.SE3) -> float:
        """Measure how near the hand at a pose of the tool comes to one entity [m]."""
        self._move(self.placed, T_wt)
        return self._nearest(self._hand, self.geoms_of(name), _FAR).distance

    def carrying(self, name: str, steps: Sequence[np.ndarray]) -> Room:
        """Measure how near a thing comes to others, taken along a way from where it lies.

        Args:
            name: The entity.
            steps: How far it has been moved, in the world [m].  # (3,) each
        """
        data, mine = self._data, self.geoms_of(name)
        others = self._others[~np.isin(self._others, mine)]
        start = data.geom_xpos[mine].copy()
        best = Room(_FAR, "")
        for step in steps:
            data.geom_xpos[mine] = start + step
            best = min(best, self._nearest(mine.tolist(), others, 0.02))
        data.geom_xpos[mine] = start
        return best

    def _move(self, placed: dict[int, pin.SE3], T_wt: pin.SE3) -> None:
        data = self._data
        for geom, T_tg in placed.items():
            T_wg = T_wt * T_tg
            data.geom_xpos[geom] = T_wg.translation
            data.geom_xmat[geom] = T_wg.rotation.ravel()

    def _nearest(self, mine: Sequence[int], others: np.ndarray, far: float) -> Room:
        best = Room(far, "")
        for geom in mine:
            for other in self._near(geom, others, best.distance):
                distance = mujoco.mj_geomDistance(
                    self._model, self._data, int(geom), int(other), max(best.distance, _LEAST), None
                )
                if distance < best.distance:
                    best = Room(float(distance), self._label[int(other)])
        return best

    def _near(self, geom: int, others: np.ndarray, far: float) -> np.ndarray:
        """Choose the geoms whose bounding spheres are near; planes have none."""
        if not len(others):
            return others
        model, data = self._model, self._data
        offset = data.geom_xpos[others] - data.geom_xpos[geom]
        gap = np.sqrt((offset * offset).sum(axis=1)) - model.geom_rbound[others]
        plane = model.geom_type[others] == int(mujoco.mjtGeom.mjGEOM_PLANE)
        return others[plane | (gap - model.geom_rbound[geom] < far)]


def with_clearance(poses: Sequence[pin.SE3], room: GripperClearance) -> tuple[list[pin.SE3], Room]:
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


def _pose(position: np.ndarray, matrix: np.ndarray) -> pin.SE3:
    return pin.SE3(matrix.reshape(3, 3).copy(), position.copy())


def _entity(model: mujoco.MjModel, body: int) -> str:
    name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body)
    return (name or "").partition("/")[0]
