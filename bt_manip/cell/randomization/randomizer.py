"""Draws what varies when an episode begins, and lets the cell be so."""

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
from .observation_noise import observe_with
from .randomization import (
    PHYSICAL,
    POSE,
    Lines,
    Randomization,
    unknown_quantity,
)
from .sampling import Varied, draw, stream
from .scene_objects import SceneObject, SceneObjects


class Randomizer:
    """Varies a cell, episode by episode.

    Everything drawn follows from the seed, the number of the episode, and the name of what is
    varied: it neither takes from nor gives to any other randomness. Things that come into the cell
    in the course of an episode are varied as they come.
    """

    def __init__(
        self,
        randomization: Randomization,
        cell: Cell,
        catalogue: Catalogue,
        *,
        seed: int,
        stands: Mapping[str, SceneObject],
        robots: tuple[str, ...] = (),
    ) -> None:
        """Know what varies.

        Args:
            randomization: What varies, and by what.
            cell: Where it varies.
            catalogue: Makes the objects, of the scene and later ones.
            seed: Seed of the run.
            stands: What stands in the scene, by name.
            robots: Names of the robots in the cell.

        Raises:
            CellError: When something shall vary that there is not.
        """
        self._randomization = randomization
        self._cell, self._catalogue, self._seed = cell, catalogue, seed
        self._robots = robots
        self._stands = SceneObjects(cell, catalogue, stands)
        self._cycle: int | None = None
        self._resumed: int | None = None
        self._drawn: dict[str, dict[str, dict[str, Any]]] = {}
        self._made: dict[str, int] = {}
        self._check()

    @property
    def sampled(self) -> dict[str, dict[str, dict[str, Any]]]:
        """What was drawn in this episode, as plain data: by kind of thing, thing and quantity."""
        return {
            where: {thing: dict(values) for thing, values in things.items()}
            for where, things in self._drawn.items()
        }

    def begin(self, cycle: int) -> None:
        """Begin an episode, unless it is the one that was under way in the state taken back.

        Args:
            cycle: Its number.

        Raises:
            CellError: When a value was drawn that is impossible, or no free pose was found.
        """
        resumed, self._resumed = self._resumed, None
        if cycle == resumed:
            return
        self._cycle, self._drawn, self._made = cycle, {}, {}
        self._listen()
        for name in self._stands.present():
            self._place(name)
        model = self._cell.nominal_model
        for name, entity in self._cell.entities.items():
            values = self.values_of(name, entity, model)
            if values:
                self._cell.override(name, **values)
        for where, kind in (("lights", "light"), ("cameras", "camera")):
            for name, lines in getattr(self._randomization, where).items():
                thing = f"{kind}:{name}"
                values = {
                    q: self._draw(where, name, q, varied, self._cell.nominal(thing, q))
                    for q, varied in lines.items()
                }
                self._cell.override(thing, **values)

    def values_of(
        self, name: str, entity: composer.Entity, model: mujoco.MjModel
    ) -> dict[str, Any]:
        """Draw how the physics of a thing differs from its model in this episode.

        Args:
            name: Its name in the cell.
            entity: The thing.
            model: As it was compiled.

        Raises:
            CellError: When something shall vary that the thing does not have.
        """
        where = "robots" if name in self._robots else "objects"
        values = {}
        for quantity, varied in self._lines(where, name, entity):
            if quantity in PHYSICAL:
                nominal = nominal_value(model, name, quantity)
                if quantity == "colour":  # opacity does not vary
                    nominal = nominal[:3]
                values[quantity] = self._draw(where, name, quantity, varied, nominal)
        self._observe(name, entity)
        return values

    # Its state

    def get_state(self) -> dict[str, Any]:
        """Give what the rest of the episode follows from, as plain data."""
        return {"cycle": self._cycle, "drawn": self.sampled, "made": dict(self._made)}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Take it back, after the cell has taken its own back."""
        self._cycle = self._resumed = state["cycle"]
        self._made = dict(state["made"])
        self._drawn = {w: {t: dict(v) for t, v in s.items()} for w, s in state["drawn"].items()}
        if self._cycle is not None:
            self._listen()
            for name, entity in self._cell.entities.items():
                self._observe(name, entity)

    def _listen(self) -> None:
        if not self._randomization:
            return
        self._cell.initial_overrides = self.values_of
        self._catalogue.vary = self._parameters

    # Inside

    def _check(self) -> None:
        """Find what nobody knows, before anything is simulated.

        Raises:
            CellError: When there is such a name or quantity.
        """
        random = self._randomization
        for name in random.robots:
            if name not in self._robots:
                raise CellError(f"robots '{name}' is not there{did_you_mean(name, self._robots)}")
        for where, kind in (("lights", "light"), ("cameras", "camera")):
            for name, lines in getattr(random, where).items():
                for quantity in lines:
                    self._cell.nominal(f"{kind}:{name}", quantity)
        for name, lines in random.objects.items():
            self._check_object(name, lines)

    def _check_object(self, key: str, lines: Mapping[str, Varied]) -> None:
        standing = [stand for name, stand in self._stands if _meant(key, name, stand.model)]
        registered = key in self._catalogue.names()
        if not standing and not registered and not is_address(key) and not _is_pattern(key):
            names = (*(name for name, _ in self._stands), *self._catalogue.names())
            raise CellError(
                f"objects '{key}' neither stands in the scene nor is registered"
                + did_you_mean(key, names)
            )
        if set(lines) <= {*PHYSICAL, *POSE}:
            return
        parameters = [stand.parameters(self._catalogue) for stand in standing]
        if registered or is_address(key):
            parameters.append(self._catalogue.nominal(key).parameters)
        for known in parameters:
            for quantity in lines:
                allowed = dict.fromkeys((*PHYSICAL, *POSE, *known))
                if quantity not in allowed:
                    raise unknown_quantity("objects", key, quantity, tuple(allowed))

    def _lines(
        self, where: str, name: str, entity: composer.Entity
    ) -> Iterator[tuple[str, Varied]]:
        """Go through what varies of a thing; where lines differ, the last one counts."""
        lines: Lines = getattr(self._randomization, where)
        merged: dict[str, Varied] = {}
        for key, varied in lines.items():
            if _meant(key, name, as_object(entity).kind):
                merged.update(varied)
        yield from merged.items()

    def _draw(
        self, where: str, name: str, quantity: str, varied: Varied, nominal: Any, *key: int
    ) -> Any:
        """Draw a value and note it."""
        assert self._cycle is not None
        source = stream(self._seed, self._cycle, where, name, quantity, *key)
        try:
            value = draw(varied, nominal, source)
        except (TypeError, ValueError) as error:
            raise CellError(f"{where} '{name}': {quantity} cannot be drawn: {error}") from error
        self._drawn.setdefault(where, {}).setdefault(name, {})[quantity] = value
        return value

    def _place(self, name: str) -> None:
        """Let something of the scene have other measures, or stand elsewhere."""
        entity = self._cell.entities[name]
        lines = dict(self._lines("objects", name, entity))
        made_with = {q: v for q, v in lines.items() if q not in (*PHYSICAL, *POSE)}
        posed = {q: v for q, v in lines.items() if q in POSE}
        if not made_with and not posed:
            return

        def parameters(attempt: int) -> dict[str, Any]:
            return {
                q: self._draw("objects", name, q, v, self._stands.parameter(name, q), attempt)
                for q, v in made_with.items()
            }

        def pose(attempt: int, T_wo: pin.SE3) -> pin.SE3:
            position, yaw = T_wo.translation, 0.0
            if "position" in posed:
                position = np.array(
                    self._draw("objects", name, "position", posed["position"], position, attempt)
                )
            if "yaw" in posed:
                yaw = self._draw("objects", name, "yaw", posed["yaw"], yaw, attempt)
            turn = pin.utils.rotate("z", yaw)
            return pin.SE3(turn @ T_wo.rotation, position)

        self._stands.put(name, parameters if made_with else None, pose)

    def _parameters(self, model: str) -> dict[str, Any]:
        """Draw what an object is made with that comes in the course of the episode."""
        values: dict[str, Any] = {}
        number = self._made[model] = self._made.get(model, 0) + 1
        for key, lines in self._randomization.objects.items():
            if key != model:
                continue
            for quantity, varied in lines.items():
                if quantity not in (*PHYSICAL, *POSE):
                    nominal = self._stands.nominal(model, quantity)
                    label = model if number == 1 else f"{model} ({number})"
                    values[quantity] = self._draw("objects", label, quantity, varied, nominal)
        return values

    def _observe(self, name: str, entity: composer.Entity) -> None:
        for key, lines in self._randomization.observations.items():
            owner, _, observable = key.partition("/")
            if fnmatchcase(name, owner):
                delay = lines.get("delay")
                steps = None
                if delay is not None:
                    steps = self._draw("observations", f"{name}/{observable}", "delay", delay, 0)
                observe_with(entity, observable, noise=lines.get("noise"), delay=steps)


def _meant(key: str, name: str, kind: str | None) -> bool:
    """Tell whether a line is for a thing: by its name, a pattern of names, or what it is."""
    return key in (name, kind) or fnmatchcase(name, key)


def _is_pattern(key: str) -> bool:
    return any(sign in key for sign in "*?[")
