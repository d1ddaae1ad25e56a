"""Sampling and applying a randomization at the beginning of each cycle."""

from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer

from bt_manip.exceptions import did_you_mean
from bt_manip.models import is_address

from ..cell import Cell
from ..exceptions import CellError
from ..objects.catalogue import Catalogue
from ..objects.cell_object import as_object
from ..physics.overrides import nominal_value
from .observation_noise import add_noise_and_delay
from .randomization import PHYSICAL, POSE, Randomization, Variations, unknown_property
from .sampling import Varied, sample, stream
from .scene_objects import SceneObject, SceneObjects

_ELEMENTS = (("lights", "light"), ("cameras", "camera"))


class Randomizer:
    """Randomizes a cell in each cycle.

    Every value follows from the seed, the number of the cycle, and the name that it is for; no
    other randomness is used or changed. Entities that are added during a cycle are randomized when
    they are added.
    """

    def __init__(
        self,
        randomization: Randomization,
        cell: Cell,
        catalogue: Catalogue,
        *,
        seed: int,
        scene_objects: Mapping[str, SceneObject],
        robots: tuple[str, ...] = (),
    ) -> None:
        """Randomize a cell.

        Args:
            randomization: What varies.
            cell: The cell.
            catalogue: Makes the objects, of the scene and later ones.
            seed: Seed of the run.
            scene_objects: The objects of the scene, by name.
            robots: Names of the robots in the cell.

        Raises:
            CellError: If something varies that does not exist.
        """
        self._randomization = randomization
        self._cell, self._catalogue, self._seed = cell, catalogue, seed
        self._robots = robots
        self._objects = SceneObjects(cell, catalogue, scene_objects)
        self._cycle: int | None = None
        self._resumed: int | None = None
        self._sampled: dict[str, dict[str, dict[str, Any]]] = {}
        self._made: dict[str, int] = {}  # number of objects made in this cycle, by model
        self._check()

    @property
    def sampled(self) -> dict[str, dict[str, dict[str, Any]]]:
        """The values of this cycle as plain data: by kind (``objects``, ...), name and property."""
        return _copied(self._sampled)

    def begin(self, cycle: int) -> None:
        """Randomize the cell for a cycle, unless it is the one that a restored state is of.

        Args:
            cycle: Its number.

        Raises:
            CellError: If a sampled value is impossible, or no free pose was found.
        """
        resumed, self._resumed = self._resumed, None
        if cycle == resumed:
            return
        self._cycle, self._sampled, self._made = cycle, {}, {}
        self._connect()
        for name in self._objects.present():
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
                nominal = nominal_value(model, name, key)
                if key == "colour":  # opacity does not vary
                    nominal = nominal[:3]
                values[key] = self._sample(kind, name, key, varied, nominal)
        self._randomize_observables(name, entity)
        return values

    # State

    def get_state(self) -> dict[str, Any]:
        """Return what the rest of the cycle depends on, as plain data."""
        return {"cycle": self._cycle, "drawn": self.sampled, "made": dict(self._made)}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state, after the cell's."""
        self._cycle = self._resumed = state["cycle"]
        self._made = dict(state["made"])
        self._sampled = _copied(state["drawn"])
        if self._cycle is not None:
            self._connect()
            for name, entity in self._cell.entities.items():
                self._randomize_observables(name, entity)

    def _connect(self) -> None:
        """Randomize entities that are added, and objects that are made, from now on."""
        if self._randomization:
            self._cell.initial_overrides = self.sample_overrides
            self._catalogue.sample_parameters = self._sample_parameters

    # Checks

    def _check(self) -> None:
        """Check all names and properties before anything is simulated.

        Raises:
            CellError: If one does not exist.
        """
        random = self._randomization
        for name in random.robots:
            if name not in self._robots:
                raise CellError(f"robots '{name}' is not there{did_you_mean(name, self._robots)}")
        for kind, prefix in _ELEMENTS:
            for name, variations in getattr(random, kind).items():
                for key in variations:
                    self._cell.nominal(f"{prefix}:{name}", key)
        for name, variations in random.objects.items():
            self._check_object(name, variations)

    def _check_object(self, key: str, variations: Mapping[str, Varied]) -> None:
        present = [known for name, known in self._objects if _matches(key, name, known.model)]
        registered = key in self._catalogue.names()
        if not present and not registered and not is_address(key) and not _is_pattern(key):
            names = (*(name for name, _ in self._objects), *self._catalogue.names())
            near = did_you_mean(key, names)
            raise CellError(f"objects '{key}' neither stands in the scene nor is registered{near}")
        if set(variations) <= {*PHYSICAL, *POSE}:
            return
        parameters = [self._objects.parameters(known) for known in present]
        if registered or is_address(key):
            parameters.append(self._catalogue.nominal(key).parameters)
        for known in parameters:
            allowed = tuple(dict.fromkeys((*PHYSICAL, *POSE, *known)))
            for name in variations:
                if name not in allowed:
                    raise unknown_property("objects", key, name, allowed)

    # Sampling

    def _variations(
        self, kind: str, name: str, entity: composer.Entity
    ) -> Iterator[tuple[str, Varied]]:
        """Yield the variations of an entity by property; of several for one, the last one."""
        variations: Variations = getattr(self._randomization, kind)
        merged: dict[str, Varied] = {}
        for key, varied in variations.items():
            if _matches(key, name, as_object(entity).kind):
                merged.update(varied)
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
        """Sample parameters and pose of a scene object."""
        variations = dict(self._variations("objects", name, self._cell.entities[name]))
        made = {key: v for key, v in variations.items() if key not in (*PHYSICAL, *POSE)}
        posed = {key: v for key, v in variations.items() if key in POSE}
        if not made and not posed:
            return

        def parameters(attempt: int) -> dict[str, Any]:
            nominal = {key: self._objects.nominal_parameter(name, key) for key in made}
            return {
                key: self._sample("objects", name, key, varied, nominal[key], attempt)
                for key, varied in made.items()
            }

        def pose(attempt: int, T_wo: pin.SE3) -> pin.SE3:
            position, yaw = T_wo.translation, 0.0
            if "position" in posed:
                position = np.array(
                    self._sample("objects", name, "position", posed["position"], position, attempt)
                )
            if "yaw" in posed:
                yaw = self._sample("objects", name, "yaw", posed["yaw"], yaw, attempt)
            return pin.SE3(pin.utils.rotate("z", yaw) @ T_wo.rotation, position)

        self._objects.place(name, parameters if made else None, pose)

    def _sample_parameters(self, model: str) -> dict[str, Any]:
        """Sample the parameters of an object that is made during the cycle."""
        number = self._made[model] = self._made.get(model, 0) + 1
        name = model if number == 1 else f"{model} ({number})"
        return {
            key: self._sample(
                "objects", name, key, varied, self._objects.nominal_model_parameter(model, key)
            )
            for key, varied in self._randomization.objects.get(model, {}).items()
            if key not in (*PHYSICAL, *POSE)
        }

    def _randomize_observables(self, name: str, entity: composer.Entity) -> None:
        for key, variations in self._randomization.observations.items():
            owner, _, observable = key.partition("/")
            if fnmatchcase(name, owner):
                delay, steps = variations.get("delay"), None
                if delay is not None:
                    steps = self._sample("observations", f"{name}/{observable}", "delay", delay, 0)
                noise = variations.get("noise")
                add_noise_and_delay(entity, observable, noise=noise, delay=steps)


def _matches(key: str, name: str, kind: str | None) -> bool:
    """Tell whether a key means an entity: by its name, a pattern of names, or its kind."""
    return key in (name, kind) or fnmatchcase(name, key)


def _is_pattern(key: str) -> bool:
    return any(sign in key for sign in "*?[")


def _copied(values: Mapping[str, Any]) -> dict[str, dict[str, dict[str, Any]]]:
    return {kind: {n: dict(v) for n, v in named.items()} for kind, named in values.items()}
