"""Putting what a scene has into a cell."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from dm_control import composer

from bt_manip.cell import Cell, CellError, as_object
from bt_manip.cell.randomization import generator
from bt_manip.runner.scene import Fixture, Scene


def drawn_later(fixtures: Sequence[Fixture]) -> set[str]:
    """Name the fixtures whose places are drawn when all else stands, and what is on those."""
    later: set[str] = set()
    for fixture in fixtures:
        if fixture.region is not None or fixture.on in later:
            later.add(fixture.name)
    return later


def put_fixture(cell: Cell, fixture: Fixture, entity: composer.Entity, seed: int) -> None:
    """Put one fixture where the scene wants it.

    Args:
        cell: The cell; what the fixture is on is there already.
        fixture: What the scene says of it.
        entity: The object.
        seed: Seed of the run, for a place that is drawn.

    Raises:
        CellError: When it would be inside something else, or there is no free place.
    """
    height = 0.0
    declared = as_object(entity)
    if fixture.on:
        try:
            height = cell.surface_height(fixture.on) + declared.rest_height
        except CellError as error:
            raise CellError(f"'{fixture.name}' cannot be put there: {error}") from error
    if fixture.region is None:
        rise = pin.SE3(np.eye(3), np.array([0.0, 0.0, height]))
        cell.add(entity, rise * fixture.T_wo, name=fixture.name, free=fixture.free)
        return
    x, y, _ = declared.centre_offset
    region = replace(fixture.region, middle=(float(x), float(y)))
    if fixture.on:
        region = replace(region, z=(height, height))
    rng = generator(seed, "place", fixture.name)
    cell.place(entity, region, rng, name=fixture.name, free=fixture.free)


@contextlib.contextmanager
def told_with_file(scene: Scene) -> Iterator[None]:
    """Name the scene's file in what is wrong inside, where the scene is from a file."""
    try:
        yield
    except CellError as error:
        if not scene.source:
            raise
        raise type(error)(f"{scene.source}: {error}") from error
