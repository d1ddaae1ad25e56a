"""When an object counts as at rest."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .cell import Cell

MAX_REST_SPEED = 5e-3  # [m/s] of an object that counts as at rest
MAX_REST_TURNING = 0.2  # [rad/s] of such an object: a corner of a 50 mm cube at 9 mm/s


def at_rest(cell: "Cell", name: str) -> bool:
    """Tell whether an entity neither moves nor turns.

    Args:
        cell: The cell.
        name: Name of the entity.

    Raises:
        CellError: When there is no such entity.
    """
    velocity = cell.velocity(name)
    speed, turning = np.linalg.norm(velocity[:3]), np.linalg.norm(velocity[3:])
    return bool(speed <= MAX_REST_SPEED and turning <= MAX_REST_TURNING)
