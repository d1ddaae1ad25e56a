"""Attributes of objects used by bt-manip."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from dm_control import composer

_NO_PARAMETERS: Mapping[str, Any] = MappingProxyType({})


class DeclaredGrasp(NamedTuple):
    """A grasp declared by an object, e.g. of its handle.

    Attributes:
        T_og: Frame at the centre of the gripped part, in the object's frame; z is the approach
            direction, and the fingers close along y.
        width: Gripped width [m].
    """

    T_og: pin.SE3
    width: float


class CellObject:
    """Attributes of objects in a cell, with their defaults.

    An object is any ``composer.Entity``. It overrides defaults by class attributes, instance
    attributes or properties; it need not inherit from this class. Read the attributes by
    ``as_object(entity)``, which supplies the defaults.
    """

    @property
    def kind(self) -> str | None:
        """Registered name or address to recreate the object from a snapshot; None without one."""
        return None

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Its keyword arguments as plain data; a snapshot passes them again."""
        return _NO_PARAMETERS

    @property
    def category(self) -> str:
        """How behaviours may use it: ``graspable``, ``container``, ``surface``, ...

        If empty, it is not listed in ``Cell.objects`` unless it moves freely; so are robots.
        """
        return ""

    @property
    def free(self) -> bool:
        """Whether it moves freely (has a free joint); the default of ``Cell.add``."""
        return False

    @property
    def mass(self) -> float:
        """Its mass, for display [kg]; 0: not declared."""
        return 0.0

    @property
    def rest_height(self) -> float:
        """Height of the origin above the object's support at rest [m]."""
        return 0.0

    @property
    def centre_offset(self) -> np.ndarray:
        """Grasp centre in the object's frame; its x and y are the bottom's centre [m]."""
        return np.zeros(3)  # (3,)

    @property
    def surface_height(self) -> float | None:
        """Height above the origin at which objects are placed on it [m]; None without a surface."""
        return None

    @property
    def grasps(self) -> Sequence[DeclaredGrasp]:
        """Grasps for two fingers, in place of generated ones; empty to generate grasps.

        Sites of its model whose names begin with ``grasp`` are added: the gripped width is the
        length of a box along y, or twice the radius of other shapes.
        """
        return ()

    @property
    def tool_targets(self) -> Sequence[Sequence[pin.SE3]]:
        """Poses of the tool in the object's frame that its use requires: one of each alternatives.

        Default (empty): the tool pointing down at and above its grasp centre; for a container,
        above its bottom.
        """
        return ()

    def get_state(self) -> Any:
        """Return its state beyond MuJoCo's as plain data for snapshots; None without any."""
        return None

    def set_state(self, state: Any) -> None:
        """Restore a state returned by ``get_state``."""


class _ForeignObject(CellObject):
    """An entity as a CellObject, with defaults for undeclared attributes."""

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
    """Return the frame at the centre of an object's bottom, in the object's frame."""
    declared = as_object(entity)
    x, y, _ = declared.centre_offset
    return pin.SE3(np.eye(3), np.array([x, y, -declared.rest_height]))
