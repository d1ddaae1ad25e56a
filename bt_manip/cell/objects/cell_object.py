"""The attributes that bt-manip reads from an object."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from dm_control import composer

_NO_PARAMETERS: Mapping[str, Any] = MappingProxyType({})


class DeclaredGrasp(NamedTuple):
    """A grasp that an object brings with it, such as that of a handle.

    Attributes:
        T_og: Middle of the gripped part in the object's frame; z is the direction of approach, and
            the fingers close along y.
        width: Gripped width [m].
    """

    T_og: pin.SE3
    width: float


class CellObject:
    """The attributes that bt-manip reads from an object in a cell, with their defaults.

    An object is any ``composer.Entity``. It declares those of these attributes whose defaults do
    not fit, as class attributes, instance attributes or properties; it need not inherit from this
    class. Read them by ``as_object(entity)``, which supplies the defaults.
    """

    @property
    def kind(self) -> str | None:
        """Registered name or address that makes the object again, for snapshots; None: neither."""
        return None

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Keyword arguments that it was made with, as plain data; a snapshot passes them again."""
        return _NO_PARAMETERS

    @property
    def category(self) -> str:
        """What behaviours may do with it: ``graspable``, ``container``, ``surface``, ...

        Empty: it is not listed in ``Cell.objects`` unless it moves freely, as robots are not.
        """
        return ""

    @property
    def free(self) -> bool:
        """Whether it moves freely (gets a free joint) unless ``Cell.add`` is told otherwise."""
        return False

    @property
    def mass(self) -> float:
        """Its mass, for display [kg]; 0: not declared."""
        return 0.0

    @property
    def rest_height(self) -> float:
        """Height of the origin above the surface that the object rests on [m]."""
        return 0.0

    @property
    def centre_offset(self) -> np.ndarray:
        """Grasp centre in the object's frame; its x and y are the middle of the bottom [m]."""
        return np.zeros(3)  # (3,)

    @property
    def surface_height(self) -> float | None:
        """Height above the origin at which other objects are put on it [m]; None: not at all."""
        return None

    @property
    def grasps(self) -> Sequence[DeclaredGrasp]:
        """Grasps for two fingers that replace the generated ones; empty: those are generated.

        Sites of its model whose names begin with ``grasp`` are further ones: along y, a box has
        the gripped width, any other shape its radius twice.
        """
        return ()

    @property
    def tool_targets(self) -> Sequence[Sequence[pin.SE3]]:
        """Poses of the tool in the object's frame that its use takes: one of each alternatives.

        Empty: the tool pointing down at its grasp centre, and above it; for a container, above its
        bottom.
        """
        return ()

    def get_state(self) -> Any:
        """Return state of its own beyond MuJoCo's, as plain data for snapshots; None: no state."""
        return None

    def set_state(self, state: Any) -> None:
        """Restore what ``get_state`` returned."""


class _ForeignObject(CellObject):
    """An entity seen as a CellObject: its own attributes where declared, defaults elsewhere."""

    def __init__(self, entity: object) -> None:
        self._entity = entity

    def __getattribute__(self, name: str) -> Any:
        entity = object.__getattribute__(self, "_entity")
        try:
            return getattr(entity, name)
        except AttributeError:
            cls = entity if isinstance(entity, type) else type(entity)
            if any(name in vars(base) for base in cls.__mro__):
                raise  # from inside a property of the entity
            return object.__getattribute__(self, name)


def as_object(entity: composer.Entity | Callable[..., Any]) -> CellObject:
    """Return an entity, or a class of entities, with defaults for undeclared attributes."""
    return entity if isinstance(entity, CellObject) else _ForeignObject(entity)


def bottom_of(entity: composer.Entity) -> pin.SE3:
    """Return the middle of an object's bottom in the object's frame."""
    declared = as_object(entity)
    x, y, _ = declared.centre_offset
    return pin.SE3(np.eye(3), np.array([x, y, -declared.rest_height]))
