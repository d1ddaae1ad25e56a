"""The base of objects that are loaded from a model file."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from ..exceptions import CellError
from .cell_object import CellObject
from .object_observables import ObjectObservables


class Prop(composer.Entity, CellObject):
    """A thing in the cell: a model file, and parameters that change it.

    Subclasses name their ``kind`` and ``category`` and load their model in ``_build``. What they
    were made with is in ``parameters``, as plain data, so that a snapshot can make them again.
    """

    kind: str = "prop"
    """Name that a factory makes it by."""
    category: str = "thing"
    """What behaviours may do with it: ``graspable``, ``container``, ``surface``, ..."""
    free: bool = False
    """Whether it moves freely unless told otherwise."""

    _mjcf_root: mjcf.RootElement
    _parameters: dict[str, Any]

    def _build_observables(self) -> ObjectObservables:
        return ObjectObservables(self)

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """The model, which carries the entity's name."""
        return self._mjcf_root

    @property
    def parameters(self) -> Mapping[str, Any]:
        """What it was made with; ``None`` means: as in the model file."""
        return MappingProxyType(self._parameters)

    @property
    def collision_geoms(self) -> list[mjcf.Element]:
        """The geoms that can touch something."""
        return [g for g in self._all_geoms() if self._collides(g)]

    @property
    def visual_geoms(self) -> list[mjcf.Element]:
        """The geoms that are only looked at."""
        return [g for g in self._all_geoms() if not self._collides(g)]

    @property
    def mass(self) -> float:
        """Mass as the model file and the parameters have it [kg]."""
        return float(sum(_mass_of(g) for g in self.collision_geoms))

    @property
    def rest_height(self) -> float:
        """Height of the origin above what it stands on [m]."""
        return 0.0

    @property
    def centre_offset(self) -> np.ndarray:
        """The middle of what is gripped, seen from the origin [m]."""  # (3,)
        return np.zeros(3)

    def _load(self, path: Path, name: str, **parameters: Any) -> None:
        """Load the model file and apply what is the same for every object."""
        self._parameters = parameters
        self._mjcf_root = mjcf.from_path(str(path))
        self._mjcf_root.model = name
        mass = parameters.get("mass")
        if mass is not None:
            share = positive("mass", mass, "kg") / self.mass
            for geom in self.collision_geoms:
                geom.mass = _mass_of(geom) * share
        friction = parameters.get("friction")
        if friction is not None:
            for geom in self.collision_geoms:
                rest = (0.005, 0.0001) if geom.friction is None else tuple(geom.friction[1:])
                geom.friction = (positive("friction", friction, "-"), *rest)
        colour = parameters.get("colour")
        if colour is not None:
            rgba = colour_of(colour)
            for geom in self.visual_geoms:
                geom.material = None
                geom.rgba = rgba

    def _all_geoms(self) -> list[mjcf.Element]:
        return self._mjcf_root.find_all("geom", exclude_attachments=True)

    def _collides(self, geom: mjcf.Element) -> bool:
        """Tell by the group: 2 is seen, 3 collides (defaults of classes count)."""
        group = geom.group
        if group is None:
            group = default_of(geom, "group")
        return group != 2


def _mass_of(geom: mjcf.Element) -> float:
    mass = geom.mass if geom.mass is not None else default_of(geom, "mass")
    return float(mass or 0.0)


def default_of(geom: mjcf.Element, attribute: str) -> Any:
    """Look an attribute of a geom up in its default classes, innermost first."""
    default = geom.dclass
    while default is not None and default.tag == "default":
        value = getattr(default.geom, attribute)
        if value is not None:
            return value
        default = default.parent
    return None


def positive(name: str, value: float, unit: str) -> float:
    """Check a parameter that must be a positive finite number.

    Raises:
        CellError: When it is not.
    """
    if not np.isfinite(value) or value <= 0:
        raise CellError(f"{name} must be a positive number [{unit}], got {value!r}")
    return float(value)


def colour_of(value: Iterable[float]) -> tuple[float, ...]:
    """Check a colour: red, green, blue, and opacity where given, each from 0 to 1.

    Raises:
        CellError: When it is not one.
    """
    parts = tuple(float(part) for part in value)
    if len(parts) not in (3, 4) or not all(0 <= part <= 1 for part in parts):
        raise CellError(f"a colour is 3 or 4 numbers from 0 to 1, got {parts}")
    return (*parts, 1.0)[:4]
