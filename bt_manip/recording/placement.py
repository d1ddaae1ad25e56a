"""Check from the physics whether an object rests in a container."""

from typing import Any

import mujoco
import numpy as np

from bt_manip.cell import as_object, at_rest
from bt_manip.cell.objects import CONTAINER


class PlacementCheck:
    """Checks objects against the containers of one compiled model of a cell."""

    def __init__(self, cell: Any) -> None:
        """Compute the boxes of the containers.

        Args:
            cell: The cell; a new compile makes this check invalid.
        """
        self._cell = cell
        self.objects = {
            name: entity for name, entity in cell.objects.items() if _is_free(cell, name)
        }
        self._boxes = {
            name: _box(cell, name)
            for name, entity in cell.objects.items()
            if as_object(entity).category == CONTAINER
        }
        self._centres: dict[str, np.ndarray] = {}

    def placed(self, name: str) -> bool:
        """Return whether an object rests in a container and touches only it and other objects.

        Args:
            name: An object that moves freely.
        """
        return any(self._rests_in(name, container) for container in self._boxes)

    def _centre(self, name: str) -> np.ndarray:
        """Return the centre of an object, in its own frame [m]."""  # (3,)
        if name not in self._centres:
            lower, upper = _box(self._cell, name)
            self._centres[name] = 0.5 * (lower + upper)
        return self._centres[name]

    def _rests_in(self, name: str, container: str) -> bool:
        cell = self._cell
        lower, upper = self._boxes[container]
        # The centre of the collision geometry: tall objects are gripped far above it.
        centre = cell.pose(container).actInv(cell.pose(name).act(self._centre(name)))
        if container == name or (centre < lower).any() or (centre > upper).any():
            return False
        if not at_rest(cell, name):
            return False
        partners = {label.partition("/")[0] for label in cell.contacts.partners(name)}
        return bool(partners) and partners <= {container, *self.objects}


def _is_free(cell: Any, name: str) -> bool:
    joint = mujoco.mj_name2id(cell.model, mujoco.mjtObj.mjOBJ_JOINT, f"{name}/")
    return joint >= 0 and int(cell.model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_FREE)


def _box(cell: Any, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the box around an entity's collision geometry, in its own frame [m]."""  # 2 x (3,)
    model, data = cell.model, cell.data
    T_we = cell.pose(name)
    lower, upper = np.full(3, np.inf), np.full(3, -np.inf)
    for geom in range(model.ngeom):
        body = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, model.geom_bodyid[geom]) or ""
        if not body.startswith(f"{name}/") or not model.geom_contype[geom]:
            continue
        centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        R_eg = T_we.rotation.T @ data.geom_xmat[geom].reshape(3, 3)
        middle = T_we.actInv(data.geom_xpos[geom]) + R_eg @ centre
        reach = np.abs(R_eg) @ half
        lower, upper = np.minimum(lower, middle - reach), np.maximum(upper, middle + reach)
    return lower, upper
