"""A cell with the objects and robots of a scene."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.arm import MultiArmCoordinator
from bt_manip.cell import Cell, OverlapError
from bt_manip.cell.objects import Catalogue
from bt_manip.cell.randomization import InitialObject, Randomizer
from bt_manip.scenes import Scene, add_object, check_supports, naming_file, sampled_objects

from .commanded_robot import CommandedRobot, RobotBuilder

_ASIDE = pin.SE3(np.eye(3), np.array([0.0, 0.0, 5.0]))
"""Above its place: where an object is put that will be moved within reach of a robot [m]."""


class FilledCell:
    """A compiled cell with the objects of a scene and its commanded robots.

    Args:
        scene: The scene.
        builders: The builders of its robots.
        catalogue: Makes the objects.
        seed: Seed of sampled poses.

    Raises:
        CellError: If something overlaps, or an object finds no free pose or no pose within reach.
        BtManipError: If an object or a model does not load.

    Attributes:
        cell: The cell.
        robots: The robots by name, in the scene's order.
    """

    def __init__(
        self, scene: Scene, builders: Sequence[RobotBuilder], catalogue: Catalogue, seed: int
    ) -> None:
        self._scene, self.cell = scene, Cell()
        self._placed = [one for one in scene.objects if not one.expected]
        self._entities = [catalogue.create(one.model, **one.parameters) for one in self._placed]
        aside = False
        with naming_file(scene):
            try:
                names = self._fill(builders, seed, aside)
            except OverlapError:
                if not any(one.within_reach for one in self._placed):
                    raise
                aside = True
                names = self._fill(builders, seed, aside)
            check_supports(self.cell, scene.objects)
        pairs = zip(names, builders, strict=True)
        self.robots = {name: builder.commanded(name, self.cell) for name, builder in pairs}
        if len(self.robots) > 1:
            MultiArmCoordinator({name: one.arm for name, one in self.robots.items()})
        with naming_file(scene):
            self._reached = self._place_within_reach(aside)

    def make_randomizer(self, catalogue: Catalogue, seed: int) -> Randomizer:
        """Return the randomizer of the cell.

        Raises:
            CellError: If the scene randomizes something that is not in it.
        """
        objects = {
            one.name: InitialObject(one.model, self.cell.pose(one.name), one.parameters, one.free)
            for one in self._placed
        }
        with naming_file(self._scene):
            return Randomizer(
                self._scene.randomization, self.cell, catalogue, seed=seed, scene_objects=objects,
                robots=tuple(self.robots), reached=self._reached,
            )  # fmt: skip

    def _fill(self, builders: Sequence[RobotBuilder], seed: int, aside: bool) -> list[str]:
        """Add objects and robots; return the names of the robots.

        Objects that will be moved within reach may be put aside first. If something overlaps, the
        cell is as it was.
        """
        later = sampled_objects(self._placed)
        pairs = list(zip(self._placed, self._entities, strict=True))
        with self.cell.editing():
            for one, entity in pairs:
                if one.name not in later:
                    away = aside and one.within_reach
                    placed = replace(one, T_wo=_ASIDE * one.T_wo) if away else one
                    add_object(self.cell, placed, entity, seed)
            names = [builder.put_into(self.cell) for builder in builders]
            for one, entity in pairs:
                if one.name in later:
                    add_object(self.cell, one, entity, seed)
        return names

    def _place_within_reach(self, aside: bool) -> dict[str, Callable[[Any], bool]]:
        """Move objects within reach; return the checks that they are, by object."""
        reached: dict[str, Callable[[Any], bool]] = {}
        for one in self._placed:
            if one.within_reach:
                robot: CommandedRobot = self.robots.get(
                    str(one.within_reach), next(iter(self.robots.values()))
                )
                T_wo = _ASIDE.inverse() * self.cell.pose(one.name) if aside else None
                robot.reach.place(self.cell, one.name, T_wo)
                reached[one.name] = partial(robot.reach.reaches, self.cell, one.name)
        return reached
