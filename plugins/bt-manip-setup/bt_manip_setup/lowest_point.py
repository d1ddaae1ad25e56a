"""Lowest points of a robot's links and gripper."""

import mujoco
import numpy as np

from bt_manip.cell.objects import geom_box
from bt_manip.collision import moved_bodies
from bt_manip.robots import Robot

_VERTICAL = 0.999  # least cosine between a vertical hinge axis and the vertical


class LowestPoint:
    """Measures the lowest points of a robot with its gripper open; its foot does not count."""

    def __init__(self, robot: Robot) -> None:
        self._robot, self._model = robot, robot.mj_model
        model = self._model
        self._data = mujoco.MjData(model)
        if robot.gripper is not None:
            robot.gripper.set_opening(self._data.qpos)
        collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
        carried = moved_bodies(model, robot.dof_adr[-1:])
        links = moved_bodies(model, robot.dof_adr) & ~carried & ~foot_bodies(robot)
        self._carried, self._links = (
            np.flatnonzero(collides & bodies[model.geom_bodyid]) for bodies in (carried, links)
        )

    def of_links(self, q: np.ndarray) -> float:
        """Return the height of the lowest point of all links but the last [m]."""
        self._place(q)
        joints = self._data.xanchor[self._model.dof_jntid[self._robot.dof_adr], 2]
        return min(float(joints.min()), self._lowest(self._links))

    def below_tool(self, q: np.ndarray) -> float:
        """Return the height of the tool above the lowest point of last link and gripper [m]."""
        self._place(q)
        tool = float(self._data.site_xpos[self._robot.tool_site_id, 2])
        return tool - min(tool, self._lowest(self._carried))

    def _place(self, q: np.ndarray) -> None:
        self._data.qpos[self._robot.qpos_adr] = q
        mujoco.mj_kinematics(self._model, self._data)

    def _lowest(self, geoms: np.ndarray) -> float:
        boxes = (geom_box(self._model, self._data, int(geom)) for geom in geoms)
        return min((float(lower[2]) for lower, _ in boxes), default=np.inf)


def foot_bodies(robot: Robot) -> np.ndarray:
    """Return a mask of the bodies of constant height: fixed, or turning about the vertical only."""
    # (nbody,)
    model = robot.mj_model
    turning = model.jnt_type == int(mujoco.mjtJoint.mjJNT_HINGE)
    turning &= np.abs(robot.mj_data.xaxis[:, 2]) > _VERTICAL
    return ~moved_bodies(model, np.flatnonzero(~turning[model.dof_jntid]))
