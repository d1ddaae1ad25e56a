"""The objects of a scene, which are placed anew at the beginning of each cycle."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from ..cell import Cell
from ..exceptions import CellError, OverlapError
from ..objects.catalogue import Catalogue
from ..objects.cell_object import as_object

ATTEMPTS = 100
"""Number of poses that are sampled before an object counts as impossible to place."""


@dataclass(frozen=True)
class SceneObject:
    """An object of a scene, without variation.

    Attributes:
        model: Registered name or address of the object.
        T_wo: Its pose in the world.
        parameters: Keyword arguments that it is made with.
        free: Whether it moves freely; None: as the object declares.
    """

    model: str
    T_wo: pin.SE3
    parameters: Mapping[str, Any] = field(default_factory=dict)
    free: bool | None = False


class SceneObjects:
    """The objects of a scene by name, and their nominal parameters."""

    def __init__(
        self, cell: Cell, catalogue: Catalogue, objects: Mapping[str, SceneObject]
    ) -> None:
        """Place the objects of a scene in a cell."""
        self._cell, self._catalogue = cell, catalogue
        self._objects = dict(objects)
        self._nominal: dict[str, Any] = {}  # by name in the scene
        self._nominal_models: dict[str, Any] = {}

    def __iter__(self) -> Iterator[tuple[str, SceneObject]]:
        """Iterate over all objects by name."""
        return iter(self._objects.items())

    def present(self) -> list[str]:
        """Return the names of those that are in the cell."""
        return [name for name in self._objects if name in self._cell.entities]

    def parameters(self, scene_object: SceneObject) -> Mapping[str, Any]:
        """Return all parameters that an object has, with their nominal values."""
        return self._catalogue.nominal(scene_object.model, **scene_object.parameters).parameters

    def nominal_parameter(self, name: str, parameter: str) -> Any:
        """Return the nominal value of a scene object's parameter."""
        return _value(self._nominal_object(name), parameter)

    def nominal_model_parameter(self, model: str, parameter: str) -> Any:
        """Return the nominal value of a parameter of an object that is added during a cycle."""
        if model not in self._nominal_models:
            self._nominal_models[model] = self._catalogue.nominal(model)
        return _value(self._nominal_models[model], parameter)

    def place(
        self,
        name: str,
        sample_parameters: Callable[[int], Mapping[str, Any]] | None,
        sample_pose: Callable[[int, pin.SE3], pin.SE3],
    ) -> None:
        """Sample until an object is at a free pose.

        Args:
            name: The object.
            sample_parameters: Samples its parameters, by the number of the attempt; None: keep the
                object as it is.
            sample_pose: Samples its pose, by the number of the attempt and the nominal pose.

        Raises:
            CellError: If no pose was free in `ATTEMPTS` attempts, or it cannot be made so.
        """
        nominal = self._objects[name]
        for attempt in range(ATTEMPTS):
            try:
                if sample_parameters is None:
                    self._cell.move(name, sample_pose(attempt, nominal.T_wo))
                else:
                    pose = partial(sample_pose, attempt)
                    self._replace(name, nominal, sample_parameters(attempt), pose)
                return
            except OverlapError as error:
                reason = error
        raise CellError(f"no free place for '{name}' in {ATTEMPTS} attempts; in the last, {reason}")

    def _replace(
        self,
        name: str,
        nominal: SceneObject,
        sampled: Mapping[str, Any],
        pose: Callable[[pin.SE3], pin.SE3],
    ) -> None:
        """Replace an object by one with sampled parameters, its bottom at the same height."""
        try:
            entity = self._catalogue.nominal(nominal.model, **{**nominal.parameters, **sampled})
        except CellError as error:
            raise CellError(f"'{name}' cannot be made as sampled: {error}") from error
        before = as_object(self._nominal_object(name)).rest_height
        rise = float(as_object(entity).rest_height) - float(before)
        T_wo = pin.SE3(nominal.T_wo.rotation, nominal.T_wo.translation + np.array([0.0, 0.0, rise]))
        with self._cell.editing():
            self._cell.remove(name)
            self._cell.add(entity, pose(T_wo), name=name, free=nominal.free)

    def _nominal_object(self, name: str) -> Any:
        if name not in self._nominal:
            nominal = self._objects[name]
            self._nominal[name] = self._catalogue.nominal(nominal.model, **nominal.parameters)
        return self._nominal[name]


def _value(entity: Any, parameter: str) -> Any:
    """Return a parameter of an object; if it is None, what the object's model file says."""
    value = entity.parameters.get(parameter)
    return getattr(entity, parameter, None) if value is None else value
