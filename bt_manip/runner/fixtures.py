"""Putting what a scene has into a cell."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from dm_control import composer

from bt_manip.cell import Cell, CellError
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
    if fixture.on:
        support = cell.find(fixture.on)
        surface = getattr(support, "surface_height", None)
        if surface is None:
            raise CellError(f"'{fixture.name}' cannot be put on '{fixture.on}': it has no surface")
        rest = getattr(entity, "rest_height", 0.0)
        height = float(cell.pose(fixture.on).translation[2]) + surface + rest
    if fixture.region is None:
        rise = pin.SE3(np.eye(3), np.array([0.0, 0.0, height]))
        cell.add(entity, rise * fixture.T_wo, name=fixture.name, free=fixture.free)
        return
    x, y, _ = getattr(entity, "centre_offset", (0.0, 0.0, 0.0))
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
