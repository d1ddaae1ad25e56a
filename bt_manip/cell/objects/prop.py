"""The base class of bt-manip's objects, and their composer observables."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from dm_control import composer, mjcf
from dm_control.composer.observation import observable

from bt_manip.exceptions import did_you_mean, shown
from bt_manip.spatial import as_numbers

from ..contacts.contacts import Contacts
from ..exceptions import CellError
from ..naming import BodyNames, body_name
from .cell_object import CellObject


class ParametricEntity(composer.Entity):
    """An entity with declared parameters.

    Subclasses declare ``kind`` and ``defaults``, and create their model in ``_make_model``, or
    override ``_build``.
    """

    kind: str
    defaults: ClassVar[Mapping[str, Any]] = {}
    """The parameters by name, with their default values."""

    _mjcf_root: mjcf.RootElement
    _parameters: dict[str, Any]

    def _build(self, name: str | None = None, **parameters: Any) -> None:
        """Build the entity.

        Args:
            name: Model name; default: the kind.
            parameters: Values of parameters in ``defaults``.

        Raises:
            CellError: If there is no such parameter, or a value is impossible.
        """
        for key in parameters:
            if key not in self.defaults:
                near = did_you_mean(key, self.defaults)
                raise CellError(f"'{key}' is no parameter of a {self.kind}{near}")
        given = {**self.defaults, **parameters}
        self._parameters = {key: _plain(value) for key, value in given.items()}
        for key in parameters:
            check_kind(key, self._parameters[key], self.defaults[key])
        self._make_model(name or self.kind)

    def _make_model(self, name: str) -> None:
        """Load or build the model, given its name."""
        raise NotImplementedError

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """The model."""
        return self._mjcf_root

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Its keyword arguments; None: as in the model file."""
        return MappingProxyType(self._parameters)


class ObjectObservables(composer.Observables):
    """Pose, velocity and contact force of an object."""

    _physics: mjcf.Physics | None = None
    _contacts: Contacts

    @composer.observable
    def position(self) -> observable.Observable:
        """Position of the origin in the world [m]."""
        return observable.Generic(lambda physics: np.array(self._root(physics).xpos))

    @composer.observable
    def quat_wxyz(self) -> observable.Observable:
        """Orientation in the world."""
        return observable.Generic(lambda physics: np.array(self._root(physics).xquat))

    @composer.observable
    def velocity(self) -> observable.Observable:
        """Velocity of the origin: linear, then angular, in the world [m/s, rad/s]."""
        return observable.Generic(self._velocity)

    @composer.observable
    def contact_force(self) -> observable.Observable:
        """Sum of all external contact forces, in the world [N]."""
        return observable.Generic(self._force)

    def _root(self, physics: mjcf.Physics) -> Any:
        return physics.bind(self._entity.root_body)

    def _velocity(self, physics: mjcf.Physics) -> np.ndarray:
        data, body = physics.data.ptr, int(self._root(physics).element_id)
        centre = data.subtree_com[physics.model.ptr.body_rootid[body]]
        angular, linear = data.cvel[body, :3], data.cvel[body, 3:]
        arm = data.xpos[body] - centre
        return np.concatenate([linear + np.cross(angular, arm), angular])

    def _force(self, physics: mjcf.Physics) -> np.ndarray:
        if self._physics is not physics:
            model, data = physics.model.ptr, physics.data.ptr
            self._physics, self._contacts = physics, Contacts(model, data, BodyNames(model))
        name = body_name(self._entity.root_body.full_identifier)
        return self._contacts.wrench(name).force


class Prop(ParametricEntity, CellObject):
    """An object with a model and parameters that change it."""

    kind: str = "prop"
    category: str = "thing"
    free: bool = False

    def _build_observables(self) -> ObjectObservables:
        return ObjectObservables(self)

    @property
    def collision_geoms(self) -> list[mjcf.Element]:
        """The geoms that can collide."""
        return [g for g in self._all_geoms() if self._collides(g)]

    @property
    def visual_geoms(self) -> list[mjcf.Element]:
        """The geoms that are visible only."""
        return [g for g in self._all_geoms() if not self._collides(g)]

    @property
    def mass(self) -> float:
        """Mass according to the model and the parameters [kg]."""
        return float(sum(value_of(g, "mass") or 0.0 for g in self.collision_geoms))

    def _set_friction(self, friction: float) -> None:
        """Set the coefficient of sliding friction of the collision geoms."""
        for geom in self.collision_geoms:
            given = value_of(geom, "friction")
            rest = (0.005, 0.0001) if given is None else tuple(given[1:])
            geom.friction = (positive("friction", friction, "-"), *rest)

    def _set_colour(self, colour: Iterable[float]) -> None:
        """Set the colour of the visual geoms, or without any, of all geoms."""
        rgba = colour_of(colour)
        for geom in self.visual_geoms or self.collision_geoms:
            geom.material = None
            geom.rgba = rgba

    def _all_geoms(self) -> list[mjcf.Element]:
        return self._mjcf_root.find_all("geom", exclude_attachments=True)

    def _collides(self, geom: mjcf.Element) -> bool:
        """Return whether a geom's group, defaults included, is 3 (collision), not 2 (visual)."""
        return value_of(geom, "group") != 2


def _plain(value: Any) -> Any:
    """Return a parameter as plain data: arrays and tuples as lists."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


def check_kind(name: str, value: Any, default: Any) -> None:
    """Check that a parameter has the type and shape of its default.

    Raises:
        CellError: If it has not; a default of None accepts any value.
    """
    if default is None or name == "colour":
        return
    if isinstance(default, str | bool):
        if not isinstance(value, type(default)):
            raise CellError(f"{name} must be like {default!r}, got {shown(value)}")
        return
    like, numbers = np.asarray(default), as_numbers(value)
    whole = like.dtype.kind in "iu"
    same_shape = numbers.shape == like.shape or numbers.ndim == like.ndim == 2
    wrong_kind = whole and (numbers != np.round(numbers)).any()
    if like.dtype.kind in "iuf" and (not same_shape or np.isnan(numbers).any() or wrong_kind):
        kind = "whole number" if whole else "number"
        what = f"a {kind}" if like.ndim == 0 else f"{len(like)} {kind}s"
        what = "a list of points" if like.ndim == 2 else what
        raise CellError(f"{name} must be {what}, got {shown(value)}")


def value_of(geom: mjcf.Element, attribute: str) -> Any:
    """Return an attribute of a geom, or else of its default classes, innermost first."""
    value = getattr(geom, attribute)
    default = geom.dclass
    while value is None and default is not None and default.tag == "default":
        value = getattr(default.geom, attribute)
        default = default.parent
    return value


def positive(name: str, value: float, unit: str) -> float:
    """Check that a parameter is a positive finite number.

    Raises:
        CellError: If it is not.
    """
    number = as_numbers(value)
    if number.shape != () or not 0.0 < number < np.inf:
        raise CellError(f"{name} must be a positive number [{unit}], got {shown(value)}")
    return float(number)


def colour_of(value: Iterable[float]) -> tuple[float, ...]:
    """Check a colour: red, green, blue, and optionally opacity, each from 0 to 1.

    Raises:
        CellError: If it is not one.
    """
    parts = as_numbers(list(value) if isinstance(value, Iterable) else value)
    if parts.shape not in ((3,), (4,)) or not ((parts >= 0.0) & (parts <= 1.0)).all():
        raise CellError(f"colour must be 3 or 4 numbers from 0 to 1, got {shown(value)}")
    return (*parts.tolist(), 1.0)[:4]
