"""What stands in a scene, and how it is put there anew when an episode begins."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from ..cell import Cell
from ..exceptions import CellError, OverlapError
from ..objects.catalogue import Catalogue

ATTEMPTS = 100
"""How often a place is drawn until it is free."""


@dataclass(frozen=True)
class SceneObject:
    """Something that stands in a scene.

    Attributes:
        model: Registered name or address of the object.
        T_wo: Its pose in the world, without variation.
        made_with: What it is made with, by keyword.
        free: Whether it moves freely; None leaves it to the object.
    """

    model: str
    T_wo: pin.SE3
    made_with: Mapping[str, Any] = field(default_factory=dict)
    free: bool | None = False

    def parameters(self, catalogue: Catalogue) -> Mapping[str, Any]:
        """Give all that it could be made with."""
        return catalogue.nominal(self.model, **self.made_with).parameters


class SceneObjects:
    """What stands in a scene, by name; what was taken out of the cell is left out."""

    def __init__(self, cell: Cell, catalogue: Catalogue, stands: Mapping[str, SceneObject]) -> None:
        """Know what stands where without variation."""
        self._cell, self._catalogue = cell, catalogue
        self._stands = dict(stands)
        self._samples: dict[str, Any] = {}
        self._later: dict[str, Any] = {}

    def __iter__(self) -> Iterator[tuple[str, SceneObject]]:
        """Go through all of them."""
        return iter(self._stands.items())

    def present(self) -> list[str]:
        """Name those that are in the cell."""
        return [name for name in self._stands if name in self._cell.entities]

    def parameter(self, name: str, parameter: str) -> Any:
        """Give the nominal value of a parameter of something that stands here."""
        return _value(self._sample(name), parameter)

    def nominal(self, model: str, parameter: str) -> Any:
        """Give the nominal value of a parameter of an object that comes later."""
        if model not in self._later:
            self._later[model] = self._catalogue.nominal(model)
        return _value(self._later[model], parameter)

    def put(
        self,
        name: str,
        parameters: Callable[[int], Mapping[str, Any]] | None,
        pose: Callable[[int, pin.SE3], pin.SE3],
    ) -> None:
        """Draw until it finds a free place, and put it there.

        Args:
            name: Which one.
            parameters: Draws what it is made with, by the number of the attempt; None leaves it
                as it is.
            pose: Draws where it stands, by the number of the attempt, given where its bottom
                would be where it was without variation.

        Raises:
            CellError: When no place was free in `ATTEMPTS` attempts, or it cannot be made so.
        """
        stand = self._stands[name]
        for attempt in range(ATTEMPTS):
            try:
                if parameters is None:
                    self._cell.move(name, pose(attempt, stand.T_wo))
                else:
                    self._make_anew(name, stand, parameters(attempt), attempt, pose)
                return
            except OverlapError as error:
                reason = error
        raise CellError(f"no free place for '{name}' in {ATTEMPTS} attempts; in the last, {reason}")

    def _make_anew(
        self,
        name: str,
        stand: SceneObject,
        drawn: Mapping[str, Any],
        attempt: int,
        pose: Callable[[int, pin.SE3], pin.SE3],
    ) -> None:
        try:
            entity = self._catalogue.nominal(stand.model, **{**stand.made_with, **drawn})
        except CellError as error:
            raise CellError(f"'{name}' cannot be made as drawn: {error}") from error
        rise = _rest_height(entity) - _rest_height(self._sample(name))
        T_wo = pin.SE3(stand.T_wo.rotation, stand.T_wo.translation + np.array([0.0, 0.0, rise]))
        with self._cell.editing():
            self._cell.remove(name)
            self._cell.add(entity, pose(attempt, T_wo), name=name, free=stand.free)

    def _sample(self, name: str) -> Any:
        if name not in self._samples:
            stand = self._stands[name]
            self._samples[name] = self._catalogue.nominal(stand.model, **stand.made_with)
        return self._samples[name]


def _rest_height(entity: Any) -> float:
    return float(getattr(entity, "rest_height", 0.0))


def _value(entity: Any, parameter: str) -> Any:
    """Give what an object was made with, or what its model's file says where nobody did."""
    value = entity.parameters.get(parameter)
    return getattr(entity, parameter, None) if value is None else value
