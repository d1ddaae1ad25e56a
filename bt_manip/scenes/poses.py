"""Poses of the objects that a scene expects, where no simulation decides them."""

import abc
import os
import select
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from dm_control import composer

from bt_manip.cell import Cell, CellError
from bt_manip.cell.objects import Catalogue
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Registry

from .fixtures import support_height
from .scene import Fixture

PHYSICS = "physics"
"""Name of the default: objects are spawned in the simulation, which decides where they are."""


class PoseSource(abc.ABC):
    """Tells where the objects are that a scene expects.

    Attributes:
        expected: The expected objects.
    """

    def __init__(self, expected: Sequence[Fixture]) -> None:
        self.expected = tuple(expected)

    @abc.abstractmethod
    def pose(self, fixture: Fixture, T_wo: pin.SE3) -> pin.SE3 | None:
        """Return the pose of an object in the world; None while it is not there.

        Called once a tick while the object is awaited; it must not block.

        Args:
            fixture: The object.
            T_wo: Its pose in the world as the scene describes it.
        """

    def taken(self, name: str) -> None:
        """Note that an object was taken away.

        Args:
            name: Its name in the scene.
        """
        del name


class ScenePoses(PoseSource):
    """All expected objects are where the scene says."""

    def pose(self, fixture: Fixture, T_wo: pin.SE3) -> pin.SE3:
        """Return the pose of the scene."""
        return T_wo


class OperatorPoses(PoseSource):
    """An operator puts each object where the scene says, and confirms it with Enter."""

    _asked = ""  # name of the object that was asked for

    def pose(self, fixture: Fixture, T_wo: pin.SE3) -> pin.SE3 | None:
        """Ask once; return the pose of the scene when it is confirmed.

        Raises:
            CellError: If the input has ended.
        """
        answer = self._answer()
        if self._asked != fixture.name:  # what was entered before the question is no answer
            self._asked = fixture.name
            x, y, z = T_wo.translation
            where = f"{x:.3f} {y:.3f} {z:.3f} [m]"
            text = f"Put '{fixture.name}' ({fixture.model}) at {where}, then press Enter."
            print(text, flush=True)
            return None
        if answer == b"":
            raise CellError(f"nobody can confirm '{fixture.name}': standard input has ended")
        return T_wo if answer else None

    def taken(self, name: str) -> None:
        """Ask to take the object away."""
        print(f"Take '{name}' away.", flush=True)

    def _answer(self) -> bytes | None:
        """Return what was entered; None if nothing was, empty if the input has ended."""
        descriptor = sys.stdin.fileno()
        ready, _, _ = select.select([descriptor], [], [], 0.0)
        return os.read(descriptor, 4096) if ready else None


class ExpectedObjects:
    """The expected objects of a run, which are added to the cell one after the other.

    Args:
        cell: The cell that they are added to.
        models: Makes the objects.

    Attributes:
        source: Tells where they are.
    """

    def __init__(self, source: PoseSource, cell: Cell, models: Catalogue) -> None:
        self.source, self._cell, self._models = source, cell, models
        self._used: list[str] = []
        self._made: dict[str, composer.Entity] = {}

    def next(self, model: str = "") -> Fixture:
        """Return the next object of the scene that was not used yet, and use it.

        Args:
            model: Its model; empty: any.

        Raises:
            CellError: If there is none.
        """
        for fixture in self.source.expected:
            if fixture.name not in self._used and model in ("", fixture.model):
                self._used.append(fixture.name)
                return fixture
        of_model = f" '{model}'" if model else " object"
        raise CellError(f"the scene expects no further{of_model}: add one with 'expected = true'")

    def add(self, name: str) -> bool:
        """Add an object to the cell once its pose is known; return whether it was added.

        Raises:
            CellError: If it would penetrate something, or its pose cannot be known.
        """
        fixture = next(one for one in self.source.expected if one.name == name)
        if name not in self._made:
            self._made[name] = self._models.create(fixture.model, **fixture.parameters)
        entity = self._made[name]
        T_wo = fixture.T_wo.copy()
        T_wo.translation += np.array([0.0, 0.0, support_height(self._cell, fixture, entity)])
        found = self.source.pose(fixture, T_wo)
        if found is None:
            return False
        self._cell.add(entity, found, name=name, free=fixture.free)
        return True

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
    name: str, sources: Registry[Any], fixtures: Sequence[Fixture]
) -> PoseSource | None:
    """Return the source of poses of a scene's expected objects; None where it is the physics.

    Args:
        name: Registered name of the source of poses, or `PHYSICS`.
        sources: The registered sources.
        fixtures: The objects of the scene.

    Raises:
        BtManipError: If there is no such source, or the scene expects nothing.
    """
    if name == PHYSICS:
        return None
    if name not in sources:
        near = did_you_mean(name, (PHYSICS, *sources))
        raise BtManipError(f"unknown pose source '{name}'{near}")
    make = sources.maker(name, "pose", "taken", expected="a bt_manip.scenes.PoseSource")
    expected = [fixture for fixture in fixtures if fixture.expected]
    if not expected:
        raise BtManipError(
            f"--poses {name} needs a scene that expects objects: a scene file with "
            "'expected = true' in some of its objects"
        )
    made: PoseSource = make(expected)
    return made
