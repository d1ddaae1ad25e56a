"""The base class of bt-manip's objects, and their composer observables."""

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from dm_control import composer, mjcf
from dm_control.composer.observation import observable

from bt_manip.exceptions import did_you_mean
from bt_manip.parameters import Parameter, parameters_of

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
    """The parameters by name: a `Parameter` each, or a default. A default alone changes that of a
    base class's parameter, or declares one whose values are like it."""

    declared: ClassVar[Mapping[str, Parameter]] = {}
    """The declarations of ``defaults``."""

    _mjcf_root: mjcf.RootElement
    _parameters: dict[str, Any]

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Complete the declarations of the parameters."""
        super().__init_subclass__(**kwargs)
        known = cls.declared
        cls.declared = {
            name: replace(
                given if isinstance(given, Parameter)
                else replace(known[name], default=given) if name in known
                else cls._like(given),
                name=name,
            )
            for name, given in cls.defaults.items()
        }  # fmt: skip

    @classmethod
    def _like(cls, default: Any) -> Parameter:
        """Declare a parameter of which only the default is known."""
        return Parameter(default=default)

    def _build(self, name: str | None = None, **parameters: Any) -> None:
        """Build the entity.

        Args:
            name: Model name; default: the kind.
            parameters: Values of parameters in ``defaults``.

        Raises:
            CellError: If there is no such parameter, or a value is impossible.
        """
        self._take(parameters)
        self._make_model(name or self.kind)

    def _take(self, given: Mapping[str, Any]) -> None:
        """Check parameters, and keep them and the defaults of the others as plain data.

        Raises:
            CellError: If there is no such parameter, or a value is impossible.
        """
        for key, value in given.items():
            if key not in self.declared:
                near = did_you_mean(key, self.declared)
                raise CellError(f"'{key}' is no parameter of a {self.kind}{near}")
            check_parameter(self.declared[key], value)
        values = {key: one.default for key, one in self.declared.items()} | dict(given)
        self._parameters = {key: _plain(value) for key, value in values.items()}

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
    defaults: ClassVar[Mapping[str, Any]] = {
        "mass": Parameter(
            "Mass; by default that of its model", "kg", None, type=float, above=0.0, at_most=1e10
        ),
        "friction": Parameter(
            "Coefficient of sliding friction; by default as in its model", "", None,
            type=float, above=0.0,
        ),
        "colour": Parameter(
            "Red, green, blue, and opacity where given; by default as in its model", "", None,
            type=float, size=(3, 4), at_least=0.0, at_most=1.0,
        ),
    }  # fmt: skip

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
            geom.friction = (friction, *rest)

    def _set_colour(self, colour: Iterable[float]) -> None:
        """Set the colour of the visual geoms, or without any, of all geoms."""
        rgba = (*colour, 1.0)[:4]
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


def check_parameter(declared: Parameter, value: Any) -> None:
    """Check a value of a parameter.

    Raises:
        CellError: If it is impossible.
    """
    try:
        declared.check(value)
    except ValueError as problem:
        raise CellError(f"{declared.name} {problem}") from None


def object_parameters(factory: Callable[..., Any]) -> Mapping[str, Parameter] | None:
    """Return the parameters of an object by name; None where they are not known.

    Args:
        factory: A class of objects, or a function that makes one.
    """
    factory = inspect.unwrap(factory)
    defaults = getattr(factory, "defaults", None)
    if isinstance(defaults, Mapping):
        known = getattr(factory, "declared", {})
        return {k: known.get(k) or Parameter(default=v, name=k) for k, v in defaults.items()}
    build = getattr(factory, "_build", factory)
    try:
        kinds = {one.kind for one in inspect.signature(build).parameters.values()}
    except (TypeError, ValueError):
        return None
    if inspect.Parameter.VAR_KEYWORD in kinds:
        return None
    found = parameters_of(build)
    return {name: one for name, one in found.items() if name not in ("self", "name")}


def value_of(geom: mjcf.Element, attribute: str) -> Any:
    """Return an attribute of a geom, or else of its default classes, innermost first."""
    value = getattr(geom, attribute)
    default, body = geom.dclass, geom.parent
    while default is None and body.tag == "body":
        default, body = body.childclass, body.parent
    default = default or geom.root.default
    while value is None and default.tag == "default":
        value = getattr(default.geom, attribute)
        default = default.parent
    return value
