"""Trying out where a thing could stand, before it is put there."""

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell.contacts.overlap import Overlap, deepest_overlap
from bt_manip.cell.naming import BodyNames
from bt_manip.spatial import pose as make_pose
from bt_manip.spatial import quat_wxyz

_STILL = (5e-3, 0.05)  # [m/s], [rad/s]
_STILL_STEPS = 50
_MOST_STEPS = 2000


class Probe:
    """A copy of a cell with one thing more, which is moved about in it.

    Nothing in here is seen by the cell.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, name: str, free: bool):
        """Take over a model and its data.

        Args:
            model: The cell's model with the thing in it.
            data: Its data, with the state of all that is there already.
            name: Name of the thing.
            free: Whether it moves freely.
        """
        self._model, self._data, self._name = model, data, name
        self._labels = BodyNames(model)
        self._body = int(model.body(f"{name}/").id)
        self._free = free
        self._q = np.arange(0)
        self._v = np.arange(0)
        if free:
            joint = model.joint(f"{name}/")
            self._q = np.arange(7) + joint.qposadr[0]
            self._v = np.arange(6) + joint.dofadr[0]

    def overlap(self, T_wo: pin.SE3) -> Overlap | None:
        """Put the thing at a pose; give the deepest overlap with anything else."""
        numbers = (*T_wo.translation, *quat_wxyz(T_wo))
        if self._free:
            self._data.qpos[self._q] = numbers
            self._data.qvel[self._v] = 0.0
        else:
            self._model.body_pos[self._body] = numbers[:3]
            self._model.body_quat[self._body] = numbers[3:]
        mujoco.mj_fwdPosition(self._model, self._data)
        return deepest_overlap(self._model, self._data, self._labels, self._name)

    def drop(self) -> pin.SE3 | None:
        """Let the thing fall while all else stands still; give where it comes to rest, if it does.

        It rests when it has been slower than 5 mm/s and 0.05 rad/s for 50 steps on end, within
        2000 steps.
        """
        model, data = self._model, self._data
        others_q = np.delete(data.qpos, self._q)
        q = np.setdiff1d(np.arange(model.nq), self._q)
        v = np.setdiff1d(np.arange(model.nv), self._v)
        still = 0
        for _ in range(_MOST_STEPS):
            data.qvel[v] = 0.0
            mujoco.mj_step(model, data)
            data.qpos[q] = others_q
            linear, angular = (np.linalg.norm(data.qvel[self._v[i : i + 3]]) for i in (0, 3))
            still = still + 1 if linear < _STILL[0] and angular < _STILL[1] else 0
            if still == _STILL_STEPS:
                at = data.qpos[self._q]
                return make_pose(at[:3], at[3:])
        return None
