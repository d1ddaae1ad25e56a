"""Search for a free pose of a new entity."""

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.spatial import pose as make_pose
from bt_manip.spatial import quat_wxyz

from ..contacts.overlap import Overlap, deepest_overlap
from ..exceptions import CellError
from ..naming import BodyNames
from ..region import Region

FREE_OVERLAP = 1e-4
"""Largest penetration at a free pose [m]; objects placed on a surface touch it."""

_REST_VELOCITY = (5e-3, 0.05)  # [m/s], [rad/s]
_REST_STEPS = 50  # consecutive steps below these velocities of an entity at rest
_MAX_DROP_STEPS = 2000


class PlacementSearch:
    """A copy of a cell's physics with one more entity, to be tested at several poses.

    Args:
        model: The cell's model with the new entity; its data are changed.
        data: Its data, with the state of all other entities.
        name: Name of the new entity.
        free: Whether it moves freely.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, name: str, free: bool):
        self._model, self._data, self._name = model, data, name
        self._body_names = BodyNames(model)
        self._body = int(model.body(f"{name}/").id)
        self._free = free
        self._q = self._v = np.arange(0)
        if free:
            joint = model.joint(f"{name}/")
            self._q = np.arange(7) + joint.qposadr[0]
            self._v = np.arange(6) + joint.dofadr[0]

    def search(
        self,
        region: Region,
        rng: np.random.Generator,
        *,
        first: pin.SE3,
        attempts: int,
        drop: bool,
    ) -> pin.SE3:
        """Return the first free pose of those sampled from a region.

        Args:
            region: Region of the entity's origin.
            rng: Random generator for the poses.
            first: The pose to try first.
            attempts: Maximum number of poses.
            drop: Whether the entity falls from the pose, and has to come to rest in the region.

        Raises:
            CellError: If no pose was free; the message has the reason for the last one.
        """
        T_wo = first
        for attempt in range(attempts):
            if attempt:
                T_wo = region.sample(rng)
            overlap = self.overlap(T_wo)
            if overlap is not None and overlap.depth > FREE_OVERLAP:
                reason = str(overlap)
                continue
            if not drop:
                return T_wo
            rested = self.drop()
            if rested is None:
                reason = "it does not come to rest"
            elif not region.covers(rested):
                reason = "it does not stay in the region"
            else:
                return rested
        raise CellError(f"no free pose in {attempts} attempts; in the last, {reason}")

    def overlap(self, T_wo: pin.SE3) -> Overlap | None:
        """Set the entity's pose; return the deepest overlap with other entities."""
        numbers = (*T_wo.translation, *quat_wxyz(T_wo))
        if self._free:
            self._data.qpos[self._q] = numbers
            self._data.qvel[self._v] = 0.0
        else:
            self._model.body_pos[self._body] = numbers[:3]
            self._model.body_quat[self._body] = numbers[3:]
        mujoco.mj_fwdPosition(self._model, self._data)
        return deepest_overlap(self._model, self._data, self._body_names, self._name)

    def drop(self) -> pin.SE3 | None:
        """Let the entity fall while all other entities stand still; return its pose at rest.

        At rest it has been slower than 5 mm/s and 0.05 rad/s for 50 consecutive steps.

        Returns:
            The pose, or None if it is not at rest after 2000 steps.
        """
        model, data = self._model, self._data
        others_q = np.delete(data.qpos, self._q)
        q = np.setdiff1d(np.arange(model.nq), self._q)
        v = np.setdiff1d(np.arange(model.nv), self._v)
        at_rest = 0
        for _ in range(_MAX_DROP_STEPS):
            data.qvel[v] = 0.0
            mujoco.mj_step(model, data)
            data.qpos[q] = others_q
            linear, angular = (np.linalg.norm(data.qvel[self._v[i : i + 3]]) for i in (0, 3))
            slow = linear < _REST_VELOCITY[0] and angular < _REST_VELOCITY[1]
            at_rest = at_rest + 1 if slow else 0
            if at_rest == _REST_STEPS:
                at = data.qpos[self._q]
                return make_pose(at[:3], at[3:])
        return None
