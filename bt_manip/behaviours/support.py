"""Surfaces to place objects on, and their free positions."""

from collections.abc import Iterator
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell, CellError, collision_geoms, extent
from bt_manip.exceptions import did_you_mean

from .poses import yaw_of

GAP = 0.02
"""Distance between an object and its neighbours on a support [m]."""

_HEADROOM = 5e-3  # [m] height over a support above which other objects occupy it
_STEPS = 8  # maximum number of grid steps in each direction from the centre


class Support(NamedTuple):
    """The top of an object or of a named geom of it.

    Attributes:
        entity: Name of the object.
        top: Centre of the top in the world [m].  # (3,)
        yaw: Rotation about the vertical [rad].
        half: Half lengths along its own axes [m].  # (2,)
    """

    entity: str
    top: np.ndarray
    yaw: float
    half: np.ndarray

    def at(self, offset: np.ndarray) -> np.ndarray:
        """Return the position at an offset from the centre along its own axes [m]."""  # (3,)
        return np.asarray(self.top + pin.utils.rotate("z", self.yaw) @ [*offset, 0.0])

    def free_offsets(self, cell: Cell, name: str) -> Iterator[np.ndarray]:
        """Yield offsets at which an object fits between others, the centre first.

        Except at the centre, the object is entirely on the support at any yaw.

        Args:
            cell: The cell.
            name: The object.
        """
        lower, upper = extent(cell, name)
        half = 0.5 * (upper - lower)
        radius = float(np.hypot(*half[:2]))
        boxes = [
            extent(cell, other)
            for other in cell.objects
            if other not in (name, self.entity) and collision_geoms(cell, other).size
        ]
        bottom = self.top[2] + _HEADROOM
        room = np.maximum(self.half - radius, 0.0)
        step = max(radius + 0.5 * GAP, float(room.max()) / _STEPS)
        axes = [step * np.arange(-int(r / step), int(r / step) + 1) for r in room]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        for offset in grid[np.argsort(np.linalg.norm(grid, axis=1), kind="stable")]:
            middle = self.at(offset)
            low = np.array([*(middle[:2] - half[:2] - GAP), bottom])
            high = np.array([*(middle[:2] + half[:2] + GAP), bottom + 2.0 * half[2]])
            if not any((b[0] < high).all() and (low < b[1]).all() for b in boxes):
                yield offset


def find_support(cell: Cell, name: str) -> Support:
    """Return the top of an object, or that of a geom named ``object/geom``.

    Args:
        cell: The cell.
        name: The object, or the geom, such as ``shelf/board_1``.

    Raises:
        CellError: If there is no such object or geom.
    """
    entity, _, part = name.rpartition("/")
    if name in cell.entities or entity not in cell.entities:
        lower, upper = extent(cell, name)
        T_we = cell.pose(name)
        own_lower, own_upper = extent(cell, name, T_we)
        centre = 0.5 * (lower + upper)
        top = np.array([centre[0], centre[1], upper[2]])
        return Support(name, top, yaw_of(T_we), 0.5 * (own_upper - own_lower)[:2])
    model, data = cell.model, cell.data
    geom = mujoco.mj_name2id(model, int(mujoco.mjtObj.mjOBJ_GEOM), name)
    if geom < 0:
        names = [model.geom(i).name for i in np.flatnonzero(cell.contacts.geoms(entity))]
        raise CellError(f"'{entity}' has no geom '{part}'{did_you_mean(name, filter(None, names))}")
    half = model.geom_aabb[geom, 3:]
    T_wg = pin.SE3(data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom])
    centre = T_wg.act(np.array(model.geom_aabb[geom, :3]))
    height = float(np.abs(T_wg.rotation[2]) @ half)
    return Support(entity, centre + [0.0, 0.0, height], yaw_of(T_wg), np.array(half[:2]))
