"""Adding the objects of a scene to a cell."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from dm_control import composer

from bt_manip.cell import Cell, CellError, as_object
from bt_manip.cell.randomization import generator
from bt_manip.runner.scene import Fixture, Scene


def sampled_fixtures(fixtures: Sequence[Fixture]) -> set[str]:
    """Return the names of fixtures with a sampled pose, and of those on them: added last."""
    later: set[str] = set()
    for fixture in fixtures:
        if fixture.region is not None or fixture.on in later:
            later.add(fixture.name)
    return later


def add_fixture(cell: Cell, fixture: Fixture, entity: composer.Entity, seed: int) -> None:
    """Add a fixture at its pose in the scene.

    Args:
        cell: The cell, with the fixture that it is on.
        fixture: The fixture.
        entity: The object.
        seed: Seed of the run, for a sampled pose.

    Raises:
        CellError: If it would penetrate something, or there is no free pose.
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
def naming_file(scene: Scene) -> Iterator[None]:
    """Prefix errors with the file of a scene that was read from a file."""
    try:
        yield
    except CellError as error:
        if not scene.source:
            raise
        raise type(error)(f"{scene.source}: {error}") from error
