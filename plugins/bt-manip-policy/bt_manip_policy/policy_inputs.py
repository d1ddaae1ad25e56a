"""The observations of a policy: observations of the station by their names in the policy."""

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar, cast

import numpy as np

from bt_manip.cell import Cell
from bt_manip.runner import CommandedRobot
from bt_manip_learn.agents import Images, Observations

from .policy_process import LoadedPolicy

T = TypeVar("T")

OF_OBJECTS = {
    "position": (3,), "rotation": (6,), "velocity": (6,), "contact_wrench": (6,),
    "joint_positions": (),
}  # fmt: skip
"""Observations of objects, with their shapes; the shape of joints depends on the object."""

OF_CAMERAS = {"rgb": 3, "depth": 2}
"""Kinds of images, with their numbers of dimensions."""

OBJECT = "object_"
"""Prefix of the observations of the object of the port ``object``."""


class PolicyInputs:
    """Reads the observations of a robot and its cell for a policy, images included.

    Args:
        policy: The policy.
        cell: The cell.
        robots: The controlled robot, by name.
        object_name: The object that is observed as 'object'; empty for none, None if it is unknown
            yet.

    Raises:
        PolicyError: If it expects images of several sizes, or of any size.
    """

    def __init__(
        self,
        policy: LoadedPolicy,
        cell: Cell,
        robots: Mapping[str, CommandedRobot],
        object_name: str | None,
    ) -> None:
        self._policy, self._cell, self._object_name = policy, cell, object_name
        self._observations = Observations(cell, robots, _images(policy, cell))

    def close(self) -> None:
        """Free the renderers of images."""
        self._observations.close()

    def read(self) -> dict[str, np.ndarray]:
        """Return the observations required by the policy.

        Raises:
            CellError: If it requires images and nothing can be rendered.
        """
        inputs = self._policy.inputs
        return {n: x for n, x in self._named(self._observations.read()) if n in inputs}

    def read_or_zero(self) -> dict[str, np.ndarray]:
        """Return the same observations, with zeros for objects that may be added later."""
        found = self.read()
        for name, expected in self._policy.inputs.items():
            shape = None if name in found else self._shape_of_absent(name)
            if shape is not None:
                one = expected if self._policy.history == 1 else expected[1:]
                found[name] = np.zeros(shape or [n or 1 for n in one], np.float32)
        return found

    def known(self) -> dict[str, tuple[int, ...]]:
        """Return the shapes of all observations of the station."""
        return {name: spec.shape for name, spec in self._named(self._observations.specs)}

    def _named(self, values: Mapping[str, T]) -> Iterator[tuple[str, T]]:
        """Yield observations; those of the port's object also under the name 'object'."""
        yield from values.items()
        if self._object_name:
            prefix = f"{self._object_name}_"
            for name, value in values.items():
                if name.startswith(prefix):
                    yield OBJECT + name.removeprefix(prefix), value

    def _shape_of_absent(self, name: str) -> tuple[int, ...] | None:
        """Return the shape of an observation of an object that may be added later.

        Returns:
            Empty if the shape depends on the object; None if it is no such observation.
        """
        known = {*self._cell.entities, "robot"}
        if self._object_name == "":
            known.add("object")
        for quantity, shape in OF_OBJECTS.items():
            owner = name.removesuffix(f"_{quantity}")
            if owner != name and owner not in known and not owner.startswith("robot_"):
                return shape
        return None


def with_history(past: list[dict[str, Any]], length: int) -> dict[str, np.ndarray]:
    """Return successive observations, the oldest first; at the start, the oldest is repeated.

    Args:
        past: Observations, the present ones last.
        length: Number of observations.
    """
    if length == 1:
        return past[-1]
    rows = [past[0]] * (length - len(past)) + past[-length:]
    return {name: np.stack([row[name] for row in rows]) for name in past[-1]}


def _images(policy: LoadedPolicy, cell: Cell) -> Images | None:
    """Return the images required by a policy."""
    names = (cell.model.camera(i).name for i in range(cell.model.ncam))
    by_name = {name.replace("/", "_"): name for name in names}
    cameras: dict[str, None] = {}
    kinds: dict[str, None] = {}
    sizes = set()
    for name, shape in policy.inputs.items():
        for kind, dimensions in OF_CAMERAS.items():
            camera = by_name.get(name.removesuffix(f"_{kind}"))
            if camera is not None and name.endswith(kind) and len(shape) >= dimensions:
                cameras[camera] = kinds[kind] = None
                sizes.add(shape[len(shape) - dimensions :][:2])
    if not cameras:
        return None
    if len(sizes) > 1 or None in next(iter(sizes)):
        raise policy.error("expects images of several sizes, or of any size")
    ((height, width),) = sizes
    return Images(tuple(kinds), tuple(cameras), cast(int, width), cast(int, height))
