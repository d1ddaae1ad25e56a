"""Pose sources: where the expected objects of a scene are, when no simulation decides it."""

import abc
import os
import select
import sys
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import pinocchio as pin
from dm_control import composer

from bt_manip.cell import Cell, CellError
from bt_manip.cell.objects import Catalogue
from bt_manip.exceptions import BtManipError
from bt_manip.packages import suggestion
from bt_manip.registry import Registry

from .objects import raised, support_height
from .scene import SceneObject

PHYSICS = "physics"
"""Name of the default: objects are spawned in the simulation, which has their poses."""


class PoseSource(abc.ABC):
    """Source of the poses of a scene's expected objects.

    Attributes:
        expected: The expected objects.
    """

    believed_cell: ClassVar[Callable[..., Any] | None] = None
    """Where a simulation has the expected objects from the start and the tree knows only what is
    reported: makes the cell that the tree gets in its place, a `bt_manip.runner.Believed`."""

    def __init__(self, expected: Sequence[SceneObject]) -> None:
        self.expected = tuple(expected)

    @abc.abstractmethod
    def pose(self, scene_object: SceneObject, T_wo: pin.SE3) -> pin.SE3 | None:
        """Return the pose of an object in the world; None while it is absent.

        Called once per tick while the object is awaited; it must not block.

        Args:
            scene_object: The object.
            T_wo: Its pose in the world as the scene describes it.
        """

    def taken(self, name: str) -> None:
        """Note that an object was taken away.

        Args:
            name: Its name in the scene.
        """
        del name


class ScenePoses(PoseSource):
    """All expected objects are at their poses in the scene."""

    def pose(self, scene_object: SceneObject, T_wo: pin.SE3) -> pin.SE3:
        """Return the pose of the scene."""
        return T_wo


class OperatorPoses(PoseSource):
    """An operator puts each object at its pose in the scene, and confirms with Enter."""

    _asked = ""  # name of the last requested object

    def pose(self, scene_object: SceneObject, T_wo: pin.SE3) -> pin.SE3 | None:
        """Ask once; return the scene's pose after the confirmation, which needs an open input."""
        answer = self._answer()
        if self._asked != scene_object.name:  # earlier input does not count as an answer
            self._asked = scene_object.name
            x, y, z = T_wo.translation
            where = f"{x:.3f} {y:.3f} {z:.3f} [m]"
            text = f"Put '{scene_object.name}' ({scene_object.model}) at {where}, then press Enter."
            print(text, flush=True)
            return None
        if answer == b"":
            raise CellError(f"nobody can confirm '{scene_object.name}': standard input has ended")
        return T_wo if answer else None

    def taken(self, name: str) -> None:
        """Ask to take the object away."""
        print(f"Take '{name}' away.", flush=True)

    def _answer(self) -> bytes | None:
        """Return the input since the last call; None without input, empty at its end."""
        descriptor = sys.stdin.fileno()
        ready, _, _ = select.select([descriptor], [], [], 0.0)
        return os.read(descriptor, 4096) if ready else None


class ExpectedObjects:
    """The expected objects of a run, added to the cell one after the other.

    Args:
        cell: The cell.
        models: Creates the objects.

    Attributes:
        source: Source of their poses.
        physics: The cell in which objects that the tree adds appear, to be expected from then on;
            None where only the scene's objects are.
    """

    physics: Cell | None = None

    def __init__(self, source: PoseSource, cell: Cell, models: Catalogue) -> None:
        self.source, self._cell, self._models = source, cell, models
        self._used: list[str] = []
        self._made: dict[str, composer.Entity] = {}

    def next(self, model: str = "") -> SceneObject:
        """Return the next unused object of the scene, and mark it as used.

        Args:
            model: Model of the object; empty for any.

        Raises:
            CellError: If there is none left.
        """
        for scene_object in self.source.expected:
            if scene_object.name not in self._used and model in ("", scene_object.model):
                self._used.append(scene_object.name)
                return scene_object
        of_model = f" '{model}'" if model else " object"
        raise CellError(f"the scene expects no further{of_model}: add one with 'expected = true'")

    def add(self, name: str) -> bool:
        """Add an object to the cell if its pose is known; return whether it was added.

        Raises:
            CellError: If it would penetrate another entity, or its pose cannot be determined.
        """
        scene_object = next(known for known in self.source.expected if known.name == name)
        if name not in self._made:
            self._made[name] = self._models.create(scene_object.model, **scene_object.parameters)
        entity = self._made[name]
        height = support_height(self._cell, scene_object, entity)
        observed = self.source.pose(scene_object, raised(scene_object.T_wo, height))
        if observed is None:
            return False
        self._cell.add(entity, observed, name=name, free=scene_object.free)
        return True

    def spawned(self, name: str) -> None:
        """Expect an object that the tree has added to `physics`."""
        raise NotImplementedError

    def taken(self, name: str) -> None:
        """Note that an object was taken away."""
        if name in self._used:
            self.source.taken(name)

    def get_state(self) -> list[str]:
        """Return the names of the used objects."""
        return list(self._used)

    def set_state(self, state: Sequence[str]) -> None:
        """Restore what `get_state` returned."""
        self._used, self._made = list(state), {}


def make_pose_source(
    name: str, sources: Registry[Any], objects: Sequence[SceneObject]
) -> PoseSource | None:
    """Return the registered pose source of a scene's expected objects; None for `PHYSICS`.

    Raises:
        BtManipError: If there is no such source, or the scene has no expected objects and the tree
            cannot add any.
    """
    if name == PHYSICS:
        return None
    if name not in sources:
        near = suggestion("pose source", name, (PHYSICS, *sources))
        raise BtManipError(f"unknown pose source '{name}'{near}")
    make = sources.maker(name, "pose", "taken", expected="a bt_manip.scenes.PoseSource")
    expected = [scene_object for scene_object in objects if scene_object.expected]
    made: PoseSource = make(expected)
    if not expected and made.believed_cell is None:
        raise BtManipError(
            f"--poses {name} needs a scene that expects objects: a scene file with "
            "'expected = true' in some of its objects"
        )
    return made
