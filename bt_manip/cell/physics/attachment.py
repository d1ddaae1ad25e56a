"""How an entity stands in a cell, also as plain data."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import pinocchio as pin
from dm_control import composer

from bt_manip.spatial import pose as make_pose
from bt_manip.spatial import quat_wxyz

Factory = Callable[[Mapping[str, Any]], composer.Entity]
"""Makes the entity that a description is of."""


class Attachment(NamedTuple):
    """How an entity stands in a cell.

    The pose is kept as the numbers that the model gets: through a rotation matrix and back they
    would change in the last digit, and so would everything that follows.
    """

    entity: composer.Entity
    position: tuple[float, ...]  # (3,) [m]
    quat_wxyz: tuple[float, ...]  # (4,)
    free: bool

    @classmethod
    def of(cls, entity: composer.Entity, T_we: pin.SE3, free: bool) -> "Attachment":
        """Place an entity at a pose."""
        return cls(entity, tuple(T_we.translation.tolist()), tuple(quat_wxyz(T_we).tolist()), free)

    @classmethod
    def made(cls, description: Mapping[str, Any], factory: Factory) -> "Attachment":
        """Make an entity and place it as it was described."""
        return cls(
            factory(description),
            tuple(description["position"]),
            tuple(description["quat_wxyz"]),
            description["free"],
        )

    @property
    def pose(self) -> pin.SE3:
        """Where it was put, ``T_we``."""
        return make_pose(self.position, self.quat_wxyz)

    def describe(self, name: str) -> dict[str, Any]:
        """Say as plain data what it takes to place such an entity again."""
        return {
            "name": name,
            "kind": getattr(self.entity, "kind", None),
            "parameters": dict(getattr(self.entity, "parameters", {})),
            "free": self.free,
            "position": list(self.position),
            "quat_wxyz": list(self.quat_wxyz),
        }
