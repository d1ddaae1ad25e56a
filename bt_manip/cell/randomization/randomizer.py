"""Sampling and application of a randomization at the start of each cycle."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer
from dm_control.composer import variation
from dm_control.composer.variation import noises

from bt_manip.exceptions import did_you_mean, one_line, shown
from bt_manip.models import is_address

from ..cell import Cell
from ..exceptions import CellError, OverlapError
from ..objects.catalogue import Catalogue
from ..objects.cell_object import as_object
from ..objects.prop import Prop, check_parameter
from ..physics.overrides import check_override, nominal_value
from .randomization import (
    PHYSICAL,
    POSE,
    InitialObject,
    Randomization,
    Variations,
    unknown_property,
)
from .variations import Clipped, Varied, extremes, sample, stream

ATTEMPTS = 100
"""Maximum number of sampled poses of an object."""

ALL_FREE = "*"
"""Pattern of all freely moving objects."""

_POSE = {"position": np.zeros(3), "yaw": 0.0}
_ELEMENTS = (("lights", "light"), ("cameras", "camera"))


class _OutOfReachError(CellError):
    """A sampled pose is out of reach."""


class Randomizer:
    """Randomizes a cell in each cycle.

    Each value depends on the seed, the number of the cycle, and the names of entity and property
    only; no other random stream is used. Entities added during a cycle are randomized when they are
    added.

    Args:
        randomization: The variations.
        cell: The cell.
        catalogue: Creates the objects, of the scene and later ones.
        seed: Seed of the run.
        scene_objects: The nominal objects of the scene, by name.
        robots: Names of the robots in the cell.
        reached: Predicates that accept sampled poses, by object.

    Raises:
        CellError: If the element or property of a variation does not exist.
    """

    def __init__(
        self,
        randomization: Randomization,
        cell: Cell,
        catalogue: Catalogue,
        *,
        seed: int,
        scene_objects: Mapping[str, InitialObject],
        robots: tuple[str, ...] = (),
        reached: Mapping[str, Callable[[pin.SE3], bool]] = MappingProxyType({}),
    ) -> None:
        self._randomization = randomization
        self._cell, self._catalogue, self._seed = cell, catalogue, seed
        self._robots, self._reached = robots, reached
        self._scene = dict(scene_objects)
        # By model and name in the scene:
        self._nominal: dict[tuple[str, str | None], composer.Entity] = {}
        self._cycle: int | None = None
        self._resumed: int | None = None
        self._sampled: dict[str, dict[str, dict[str, Any]]] = {}
        self._made: dict[str, int] = {}  # number of objects created in this cycle, by model
        self._present: set[str] = set()  # keys of objects that were in the cell in this cycle
        self._check()

    @property
    def sampled(self) -> dict[str, dict[str, dict[str, Any]]]:
        """The sampled values of this cycle as plain data: by kind, name and property."""
        return _copied(self._sampled)

    @property
    def absent(self) -> list[str]:
        """Keys of varied objects of which none was in the cell in this cycle."""
        return [key for key in self._randomization.objects if key not in self._present]

    def begin(self, cycle: int) -> None:
        """Randomize the cell for a new cycle; a restored cycle keeps its sample.

        Args:
            cycle: Its number.

        Raises:
            CellError: If a sampled value is impossible, or no free pose was found.
        """
        resumed, self._resumed = self._resumed, None
        if cycle == resumed:
            return
        self._cycle, self._sampled, self._made, self._present = cycle, {}, {}, set()
        self._connect()
        for name in self._scene:
            if name in self._cell.entities:
                self._place(name)
        model = self._cell.nominal_model
        for name, entity in self._cell.entities.items():
            values = self.sample_overrides(name, entity, model)
            if values:
                self._cell.override(name, **values)
        for kind, prefix in _ELEMENTS:
            for name, variations in getattr(self._randomization, kind).items():
                element = f"{prefix}:{name}"
                values = {
                    key: self._sample(kind, name, key, varied, self._cell.nominal(element, key))
                    for key, varied in variations.items()
                }
                self._cell.override(element, **values)
        mujoco.mj_forward(self._cell.model, self._cell.data)  # forces of these values

    def sample_overrides(
        self, name: str, entity: composer.Entity, model: mujoco.MjModel
    ) -> dict[str, Any]:
        """Sample the overrides of an entity in this cycle.

        Args:
            name: Its name in the cell.
            entity: The entity.
            model: The model without overrides.

        Raises:
            CellError: If a property varies that the entity does not have.
        """
        kind = "robots" if name in self._robots else "objects"
        values = {}
        for key, varied in self._variations(kind, name, entity):
            if key in PHYSICAL:
                nominal = _nominal_value(model, name, key)
                values[key] = self._sample(kind, name, key, varied, nominal)
        self._randomize_observables(name, entity)
        return values

    def reseed(self, seed: int, moved: Iterable[str] = ()) -> None:
        """Use another seed from the next cycle on; its number is arbitrary.

        Args:
            seed: Seed of the run.
            moved: Objects of the scene whose present poses become their nominal poses.
        """
        self._seed, self._resumed = seed, None
        for name in moved:
            self._scene[name] = replace(self._scene[name], T_wo=self._cell.pose(name))

    # State

    def get_state(self) -> dict[str, Any]:
        """Return the state in the present cycle as plain data."""
        return {
            "cycle": self._cycle,
            "drawn": self.sampled,
            "made": dict(self._made),
            "present": sorted(self._present),
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state, after the state of the cell."""
        self._cycle = self._resumed = state["cycle"]
        self._made, self._present = dict(state["made"]), set(state.get("present", ()))
        self._sampled = _copied(state["drawn"])
        if self._cycle is not None:
            self._connect()
            for name, entity in self._cell.entities.items():
                self._randomize_observables(name, entity)

    def _connect(self) -> None:
        """Randomize entities and objects that are added or created from now on."""
        if self._randomization:
            self._cell.initial_overrides = self.sample_overrides
            self._catalogue.sample_parameters = self._sample_parameters

    # Checks

    def _check(self) -> None:
        """Check all names and properties."""
        random = self._randomization
        for name in random.robots:
            if name not in self._robots:
                raise CellError(f"robots '{name}' is not there{did_you_mean(name, self._robots)}")
        for kind, prefix in _ELEMENTS:
            for name, variations in getattr(random, kind).items():
                for key, varied in variations.items():
                    self._check_override(kind, name, key, varied, f"{prefix}:{name}")
        for name, variations in random.objects.items():
            self._check_object(name, variations)
        for name, entity in self._cell.entities.items():
            kind = "robots" if name in self._robots else "objects"
            for key, varied in self._variations(kind, name, entity):
                if key in PHYSICAL:
                    self._check_override(kind, name, key, varied, name)
        for name, variations in random.observations.items():
            for value in _extremes("observations", name, "delay", variations.get("delay", 0), 0):
                if value < 0:
                    raise CellError(f"the delay of '{name}' is a number of steps, got {value:g}")

    def _check_override(self, kind: str, name: str, key: str, varied: Varied, element: str) -> None:
        """Check that all samples of a physical property of an element are possible."""
        model = self._cell.nominal_model
        for value in _extremes(kind, name, key, varied, _nominal_value(model, element, key)):
            try:
                check_override(model, element, key, value)
            except CellError as error:
                raise CellError(f"{error}, which can be sampled") from None

    def _check_object(self, key: str, variations: Mapping[str, Varied]) -> None:
        present = [name for name, known in self._scene.items() if _matches(key, name, known.model)]
        pattern = any(sign in key for sign in "*?[")
        model = key in self._catalogue.names() or (is_address(key) and not pattern)
        if not (present or model or pattern):
            near = did_you_mean(key, (*self._scene, *self._catalogue.names()))
            raise CellError(f"objects '{key}' neither stands in the scene nor is registered{near}")
        for pose in POSE:
            if pose in variations:
                _extremes("objects", key, pose, variations[pose], _POSE[pose])
        if not present and model:  # added later
            nominal = {"mass": as_object(self._nominal_object(key)).mass or 1.0, "friction": 1.0}
            for name in nominal.keys() & variations.keys():
                for value in _extremes("objects", key, name, variations[name], nominal[name]):
                    check_parameter(Prop.declared[name], value)
        if set(variations) <= {*PHYSICAL, *POSE}:
            return
        models = [(self._scene[name].model, name) for name in present]
        objects = [(made, self._nominal_object(made, name)) for made, name in models]
        if model:
            objects.append((key, self._nominal_object(key)))
        for made, known in objects:
            allowed = tuple(dict.fromkeys((*PHYSICAL, *POSE, *known.parameters)))
            for name in variations:
                if name not in allowed:
                    raise unknown_property("objects", key, name, allowed)
            self._check_parameters(key, made, known, variations)

    def _check_parameters(
        self, key: str, model: str, nominal: Any, variations: Mapping[str, Varied]
    ) -> None:
        """Create an object with the smallest and with the largest sampled parameters."""
        found = {
            name: _extremes("objects", key, name, varied, _value(nominal, name))
            for name, varied in variations.items()
            if name not in (*PHYSICAL, *POSE)
        }
        for samples in zip(*found.values(), strict=False):
            parameters = {**nominal.parameters, **dict(zip(found, samples, strict=True))}
            try:
                self._catalogue.nominal(model, **parameters)
            except CellError as error:
                raise CellError(f"'{key}' cannot be made as sampled: {error}") from error

    # Sampling

    def _variations(
        self, kind: str, name: str, entity: composer.Entity
    ) -> Iterator[tuple[str, Varied]]:
        """Yield the variations of an entity by property; the last one if several match."""
        variations: Variations = getattr(self._randomization, kind)
        merged: dict[str, Varied] = {}
        for key, varied in variations.items():
            declared = as_object(entity)
            if _matches(key, name, declared.kind) and (key != ALL_FREE or declared.free):
                merged.update(varied)
                if kind == "objects":
                    self._present.add(key)
        yield from merged.items()

    def _sample(
        self, kind: str, name: str, key: str, varied: Varied, nominal: Any, *attempt: int
    ) -> Any:
        """Sample a value and record it."""
        assert self._cycle is not None
        random_state = stream(self._seed, self._cycle, kind, name, key, *attempt)
        try:
            value = sample(varied, nominal, random_state)
        except (TypeError, ValueError) as error:
            raise CellError(f"{kind} '{name}': {key} cannot be drawn: {error}") from error
        self._sampled.setdefault(kind, {}).setdefault(name, {})[key] = value
        return value

    def _place(self, name: str) -> None:
        """Sample parameters and pose of a scene object until its pose is free."""
        variations = dict(self._variations("objects", name, self._cell.entities[name]))
        made = {key: v for key, v in variations.items() if key not in (*PHYSICAL, *POSE)}
        posed = {key: v for key, v in variations.items() if key in POSE}
        if not made and not posed:
            return
        for attempt in range(ATTEMPTS):
            try:
                if made:
                    self._replace(name, made, posed, attempt)
                else:
                    T_wo = self._sample_pose(name, posed, self._scene[name].T_wo, attempt)
                    self._cell.move(name, T_wo)
                return
            except (OverlapError, _OutOfReachError) as error:
                reason = error
        raise CellError(f"no free pose for '{name}' in {ATTEMPTS} attempts; in the last, {reason}")

    def _replace(
        self, name: str, made: Mapping[str, Varied], posed: Mapping[str, Varied], attempt: int
    ) -> None:
        """Replace an object by one with sampled parameters and its bottom at the same height."""
        known = self._scene[name]
        nominal = self._nominal_object(known.model, name)
        sampled = {
            key: self._sample("objects", name, key, varied, _value(nominal, key), attempt)
            for key, varied in made.items()
        }
        try:
            entity = self._catalogue.nominal(known.model, **{**known.parameters, **sampled})
        except CellError as error:
            raise CellError(f"'{name}' cannot be made as sampled: {error}") from error
        rise = as_object(entity).rest_height - as_object(nominal).rest_height
        T_wo = pin.SE3(known.T_wo.rotation, known.T_wo.translation + np.array([0.0, 0.0, rise]))
        T_wo = self._sample_pose(name, posed, T_wo, attempt)
        with self._cell.editing():
            self._cell.remove(name)
            self._cell.add(entity, T_wo, name=name, free=known.free)

    def _sample_pose(
        self, name: str, posed: Mapping[str, Varied], T_wo: pin.SE3, attempt: int
    ) -> pin.SE3:
        sampled = {"position": T_wo.translation, "yaw": 0.0}
        for key, varied in posed.items():
            sampled[key] = self._sample("objects", name, key, varied, sampled[key], attempt)
        rotation = pin.utils.rotate("z", sampled["yaw"]) @ T_wo.rotation
        T_wo = pin.SE3(rotation, np.array(sampled["position"]))
        if name in self._reached and not self._reached[name](T_wo):
            x, y, _ = T_wo.translation
            raise _OutOfReachError(f"no robot reaches it at {x:.3f} {y:.3f} m")
        return T_wo

    def _sample_parameters(self, model: str) -> dict[str, Any]:
        """Sample the parameters of an object that is created during the cycle."""
        number = self._made[model] = self._made.get(model, 0) + 1
        self._present.add(model)
        name = model if number == 1 else f"{model} ({number})"
        return {
            key: self._sample(
                "objects", name, key, varied, _value(self._nominal_object(model), key)
            )
            for key, varied in self._randomization.objects.get(model, {}).items()
            if key not in (*PHYSICAL, *POSE)
        }

    def _nominal_object(self, model: str, name: str | None = None) -> composer.Entity:
        """Return a nominal object: the scene's object of a name, or one with default parameters."""
        if (model, name) not in self._nominal:
            parameters = {} if name is None else self._scene[name].parameters
            self._nominal[model, name] = self._catalogue.nominal(model, **parameters)
        return self._nominal[model, name]

    def _randomize_observables(self, name: str, entity: composer.Entity) -> None:
        for key, variations in self._randomization.observations.items():
            owner, _, observable = key.partition("/")
            if fnmatchcase(name, owner):
                delay, steps = variations.get("delay"), None
                if delay is not None:
                    steps = self._sample("observations", f"{name}/{observable}", "delay", delay, 0)
                noise = variations.get("noise")
                _add_noise_and_delay(entity, observable, noise=noise, delay=steps)


def _nominal_value(model: mujoco.MjModel, element: str, key: str) -> Any:
    """Return the nominal value of a property; a colour without opacity."""
    nominal = nominal_value(model, element, key)
    return nominal[:3] if key == "colour" else nominal


def _extremes(kind: str, name: str, key: str, varied: Varied, nominal: Any) -> list[Any]:
    """Return the extreme samples of a property, if its distribution is known."""
    try:
        found = extremes(varied, nominal)
    except (TypeError, ValueError) as error:
        raise CellError(f"{kind} '{name}': {key} cannot be drawn: {one_line(error)}") from error
    for value in found:
        if np.shape(value) != np.shape(nominal) and nominal is not None and key != "gain":
            raise CellError(
                f"{kind} '{name}': {key} is {np.size(nominal)} numbers, the variation gives "
                f"{shown(value)}"
            )
        if not np.isfinite(value).all():
            raise CellError(f"{kind} '{name}': {key} can be sampled as {shown(value)}")
    return found


def _matches(key: str, name: str, kind: str | None) -> bool:
    """Return whether a key matches an entity's name, as a pattern, or its kind."""
    return key in (name, kind) or fnmatchcase(name, key)


def _value(entity: composer.Entity, parameter: str) -> Any:
    """Return a parameter of an object; if it is None, the value in its model file."""
    value = entity.parameters.get(parameter)
    return getattr(entity, parameter, None) if value is None else value


def _copied(values: Mapping[str, Any]) -> dict[str, dict[str, dict[str, Any]]]:
    return {kind: {n: dict(v) for n, v in named.items()} for kind, named in values.items()}


def _add_noise_and_delay(
    entity: composer.Entity, name: str, *, noise: Varied = None, delay: float | None = None
) -> None:
    """Set noise and delay [steps] of an entity's observable, as composer's corruptor and delay.

    A variation of the value (``plus``, ``times``) replaces the observation, others are added to it.
    """
    known = entity.observables.as_dict(fully_qualified=False)
    if name not in known:
        near = did_you_mean(name, known)
        raise CellError(f"'{entity.mjcf_model.model}' has no observable '{name}'{near}")
    observable = known[name]
    if delay is not None:
        if delay < 0 or delay != round(delay):
            raise CellError(f"the delay of '{name}' is a number of steps, got {delay:g}")
        observable.delay = round(delay)
    if noise is not None:
        observable.corruptor = _corruptor(noise)


def _corruptor(noise: Varied) -> Callable[..., np.ndarray]:
    replaces = _uses_value(noise)

    def corrupt(value: Any, random_state: np.random.RandomState) -> np.ndarray:
        sampled = variation.evaluate(noise, value, value, random_state)
        return np.asarray(sampled if replaces else value + sampled)

    return corrupt


def _uses_value(noise: Varied) -> bool:
    if isinstance(noise, Clipped):
        return _uses_value(noise.varied)
    return isinstance(noise, noises.Additive | noises.Multiplicative)
