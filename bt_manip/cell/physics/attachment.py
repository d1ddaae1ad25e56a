"""An entity attached to the arena at a pose."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import pinocchio as pin
from dm_control import composer

from bt_manip.spatial import pose as make_pose
from bt_manip.spatial import quat_wxyz

from ..objects.cell_object import as_object

Factory = Callable[[Mapping[str, Any]], composer.Entity]
"""Creates the entity of a description."""


class Attachment(NamedTuple):
    """An entity attached to the arena at a pose.

    The pose is stored as the numbers in the model: converting to a rotation matrix and back would
    change the last digit, and with it the simulation.
    """

    entity: composer.Entity
    position: tuple[float, ...]  # (3,) [m]
    quat_wxyz: tuple[float, ...]  # (4,)
    free: bool

    @classmethod
    def at(cls, entity: composer.Entity, T_we: pin.SE3, free: bool) -> "Attachment":
        """Attach an entity at a pose."""
        return cls(entity, tuple(T_we.translation.tolist()), tuple(quat_wxyz(T_we).tolist()), free)

    @classmethod
    def described(cls, entity: composer.Entity, description: Mapping[str, Any]) -> "Attachment":
        """Attach an entity as described."""
        position, quat_wxyz = (tuple(description[key]) for key in ("position", "quat_wxyz"))
        return cls(entity, position, quat_wxyz, description["free"])

    @property
    def pose(self) -> pin.SE3:
        """Its initial pose ``T_we``."""
        return make_pose(self.position, self.quat_wxyz)

    def describe(self, name: str) -> dict[str, Any]:
        """Return a description from which the entity can be created and attached again."""
        entity = as_object(self.entity)
        return {
            "name": name,
            "kind": entity.kind,
            "parameters": dict(entity.parameters),
            "free": self.free,
            "position": list(self.position),
            "quat_wxyz": list(self.quat_wxyz),
        }
