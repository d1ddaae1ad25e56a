"""The objects of a scene: replaced by other models, and added to a cell."""

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
from dm_control import composer

from bt_manip.cell import Cell, CellError, as_object, bottom_of, extent
from bt_manip.cell.objects import Catalogue
from bt_manip.cell.randomization import generator
from bt_manip.models import is_address

from .scene import Fixture, Scene, SceneRobot


def fixture_models(settings: Mapping[str, str], scene: Scene) -> dict[str, str]:
    """Return the settings that are for the scene and not for the tree.

    Those are named like a fixture and have the address of a model as value, as in
    ``--set table=fuel:OpenRobotics/Table``. A plain name is for the tree.
    """
    names = {fixture.name for fixture in scene.fixtures}
    return {name: text for name, text in settings.items() if name in names and is_address(text)}


def with_models(scene: Scene, models: Mapping[str, str], catalogue: Catalogue) -> Scene:
    """Return a scene with other models for some fixtures.

    Each keeps its name, its category and the position of the middle of its bottom. If one that
    carries a robot has another height, the robot and all fixtures at its height or above move
    with it.

    Args:
        scene: The scene.
        models: Addresses of models by names of fixtures.
        catalogue: Makes objects.

    Raises:
        ModelError: If there is no model at an address.
        BtManipError: If a model cannot be used.
    """
    rise = base = 0.0
    fixtures = []
    for fixture in scene.fixtures:
        if fixture.name not in models:
            fixtures.append(fixture)
            continue
        before = catalogue.create(fixture.model, **fixture.parameters)
        parameters = {"category": as_object(before).category or None}
        after = catalogue.create(models[fixture.name], **parameters)
        T_wo = fixture.T_wo
        if not fixture.on:
            T_wo = T_wo * bottom_of(before) * bottom_of(after).inverse()
        model = models[fixture.name]
        fixtures.append(replace(fixture, model=model, T_wo=T_wo, parameters=parameters))
        carried = _carried(before, fixture, scene)
        if carried is not None:
            base = float(carried.T_wb.translation[2])
            rise = float(T_wo.translation[2] + after.surface_height - base)
    if not rise:
        return replace(scene, fixtures=tuple(fixtures))
    lifted = [
        replace(new, T_wo=_raised(new.T_wo, rise))
        if old.T_wo.translation[2] >= base - 1e-3
        else new
        for old, new in zip(scene.fixtures, fixtures, strict=True)
    ]
    robots = [
        replace(robot, T_wb=_raised(robot.T_wb, rise))
        if robot.T_wb.translation[2] >= base - 1e-3
        else robot
        for robot in scene.robots
    ]
    return replace(scene, robots=tuple(robots), fixtures=tuple(lifted))


def _carried(entity: Any, fixture: Fixture, scene: Scene) -> SceneRobot | None:
    """Return the first robot whose base is at a fixture's surface, within 1 mm; None: none."""
    surface = as_object(entity).surface_height
    if surface is None:
        return None
    height = fixture.T_wo.translation[2] + surface
    on_it = [r for r in scene.robots if abs(height - r.T_wb.translation[2]) < 1e-3]
    return on_it[0] if on_it else None


def _raised(T: pin.SE3, rise: float) -> pin.SE3:
    return pin.SE3(T.rotation, T.translation + np.array([0.0, 0.0, rise]))


def sampled_fixtures(fixtures: Sequence[Fixture]) -> set[str]:
    """Return the names of fixtures with a sampled pose, and of those on them: added last."""
    later: set[str] = set()
    for fixture in fixtures:
        if fixture.expected:
            continue
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
    declared = as_object(entity)
    height = support_height(cell, fixture, entity)
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


def support_height(cell: Cell, fixture: Fixture, entity: composer.Entity) -> float:
    """Return the height of a fixture's origin at rest on what it is on [m]; 0 if on nothing.

    Raises:
        CellError: If nothing can be put there.
    """
    if not fixture.on:
        return 0.0
    try:
        return cell.surface_height(fixture.on) + float(as_object(entity).rest_height)
    except CellError as error:
        raise CellError(f"'{fixture.name}' cannot be put there: {error}") from error


def check_supports(cell: Cell, fixtures: Sequence[Fixture]) -> None:
    """Check that fixtures on others are above them.

    Args:
        cell: The built cell.
        fixtures: The fixtures of the scene.

    Raises:
        CellError: If the middle of a fixture's bottom is beside what it is on, or the whole region
            that it is sampled from.
    """
    for fixture in fixtures:
        if not fixture.on or fixture.expected:
            continue
        lower, upper = extent(cell, fixture.on)
        if fixture.region is None:
            bottom = bottom_of(cell.find(fixture.name)).translation
            middle = cell.pose(fixture.name).act(bottom)[:2]
        else:
            bounds = np.transpose([fixture.region.x, fixture.region.y])
            middle = np.clip((lower + upper)[:2] / 2, *bounds)  # nearest to that of the support
        beside = np.maximum(lower[:2] - middle, middle - upper[:2]).max()
        if beside > 0.0:
            (x, y), (x_min, y_min, _), (x_max, y_max, _) = middle, lower, upper
            raise CellError(
                f"'{fixture.name}' is not on '{fixture.on}' but {beside:.3g} m beside it, at "
                f"{x:.3f} {y:.3f}; it extends from {x_min:.3f} to {x_max:.3f} along x and from "
                f"{y_min:.3f} to {y_max:.3f} along y [m]"
            )


def place_again(cell: Cell, fixtures: Sequence[Fixture], seed: int) -> set[str]:
    """Sample the poses of fixtures in a built cell with another seed; return their names.

    Raises:
        CellError: If there is no free pose.
    """
    later = sampled_fixtures(fixtures)
    if later:
        with cell.editing():
            entities = {name: cell.remove(name) for name in later}
            for fixture in fixtures:
                if fixture.name in later:
                    add_fixture(cell, fixture, entities[fixture.name], seed)
    return later


@contextlib.contextmanager
def naming_file(scene: Scene) -> Iterator[None]:
    """Prefix errors with the file of a scene that was read from a file."""
    try:
        yield
    except CellError as error:
        if not scene.source:
            raise
        raise type(error)(f"{scene.source}: {error}") from error
