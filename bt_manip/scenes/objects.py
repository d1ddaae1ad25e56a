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

from .scene import Scene, SceneObject, SceneRobot


def object_models(settings: Mapping[str, str], scene: Scene) -> dict[str, str]:
    """Return the settings that replace models of the scene's objects, by name of the object.

    These name an object of the scene and have the address of a model as value, as in
    ``--set table=fuel:OpenRobotics/Table``. Values that are plain names are for the tree.
    """
    names = {scene_object.name for scene_object in scene.objects}
    return {name: text for name, text in settings.items() if name in names and is_address(text)}


def with_models(scene: Scene, models: Mapping[str, str], catalogue: Catalogue) -> Scene:
    """Return a scene with other models for some objects, by their names.

    Each object keeps its name, its category and the position of its bottom's centre. If the
    object that carries a robot changes its height, the robot and all objects at its base or above
    move with it.

    Raises:
        ModelError: If there is no model at an address.
        BtManipError: If a model cannot be used.
    """
    rise = base = 0.0
    objects = []
    for scene_object in scene.objects:
        if scene_object.name not in models:
            objects.append(scene_object)
            continue
        before = catalogue.create(scene_object.model, **scene_object.parameters)
        parameters = {"category": as_object(before).category or None}
        after = catalogue.create(models[scene_object.name], **parameters)
        T_wo = scene_object.T_wo
        if not scene_object.on:
            T_wo = T_wo * bottom_of(before) * bottom_of(after).inverse()
        model = models[scene_object.name]
        objects.append(replace(scene_object, model=model, T_wo=T_wo, parameters=parameters))
        carried = _carried(before, scene_object, scene)
        if carried is not None:
            base = float(carried.T_wb.translation[2])
            rise = float(T_wo.translation[2] + after.surface_height - base)
    if not rise:
        return replace(scene, objects=tuple(objects))
    lifted = [
        replace(new, T_wo=raised(new.T_wo, rise)) if old.T_wo.translation[2] >= base - 1e-3 else new
        for old, new in zip(scene.objects, objects, strict=True)
    ]
    robots = [
        replace(robot, T_wb=raised(robot.T_wb, rise))
        if robot.T_wb.translation[2] >= base - 1e-3
        else robot
        for robot in scene.robots
    ]
    return replace(scene, robots=tuple(robots), objects=tuple(lifted))


def _carried(entity: Any, scene_object: SceneObject, scene: Scene) -> SceneRobot | None:
    """Return the first robot whose base is on an object's surface, within 1 mm, or None."""
    surface = as_object(entity).surface_height
    if surface is None:
        return None
    height = scene_object.T_wo.translation[2] + surface
    on_it = [r for r in scene.robots if abs(height - r.T_wb.translation[2]) < 1e-3]
    return on_it[0] if on_it else None


def raised(T: pin.SE3, rise: float) -> pin.SE3:
    """Return a pose in the world, raised [m]."""
    return pin.SE3(T.rotation, T.translation + np.array([0.0, 0.0, rise]))


def sampled_objects(objects: Sequence[SceneObject]) -> set[str]:
    """Return the names of objects with a sampled pose, and of objects on them; all added last."""
    later: set[str] = set()
    for scene_object in objects:
        if scene_object.expected:
            continue
        if scene_object.region is not None or scene_object.on in later:
            later.add(scene_object.name)
    return later


def add_object(cell: Cell, scene_object: SceneObject, entity: composer.Entity, seed: int) -> None:
    """Add an object at its pose in the scene, or at one sampled from its region with a run's seed.

    Its support is already in the cell.

    Raises:
        CellError: If the object would penetrate another entity, or there is no free pose.
    """
    height = support_height(cell, scene_object, entity)
    if scene_object.region is None:
        T_wo = raised(scene_object.T_wo, height)
        cell.add(entity, T_wo, name=scene_object.name, free=scene_object.free)
        return
    x, y, _ = as_object(entity).centre_offset
    region = replace(scene_object.region, middle=(float(x), float(y)))
    if scene_object.on:
        region = replace(region, z=(height, height))
    rng = generator(seed, "place", scene_object.name)
    cell.place(entity, region, rng, name=scene_object.name, free=scene_object.free)


def support_height(cell: Cell, scene_object: SceneObject, entity: composer.Entity) -> float:
    """Return the height of an object's origin at rest on its support [m]; 0 without a support.

    A support without a surface is a `CellError`.
    """
    if not scene_object.on:
        return 0.0
    try:
        return cell.surface_height(scene_object.on) + float(as_object(entity).rest_height)
    except CellError as error:
        raise CellError(f"'{scene_object.name}' cannot be put there: {error}") from error


def check_supports(cell: Cell, objects: Sequence[SceneObject]) -> None:
    """Check that objects of a built cell are above their supports.

    Raises:
        CellError: If the centre of an object's bottom, or its whole region, is beside its support.
    """
    for scene_object in objects:
        if not scene_object.on or scene_object.expected:
            continue
        lower, upper = extent(cell, scene_object.on)
        if scene_object.region is None:
            bottom = bottom_of(cell.find(scene_object.name)).translation
            middle = cell.pose(scene_object.name).act(bottom)[:2]
        else:
            bounds = np.transpose([scene_object.region.x, scene_object.region.y])
            middle = np.clip((lower + upper)[:2] / 2, *bounds)  # nearest to that of the support
        beside = np.maximum(lower[:2] - middle, middle - upper[:2]).max()
        if beside > 0.0:
            (x, y), (x_min, y_min, _), (x_max, y_max, _) = middle, lower, upper
            raise CellError(
                f"'{scene_object.name}' is not on '{scene_object.on}' but {beside:.3g} m beside "
                f"it, at {x:.3f} {y:.3f}; it extends from {x_min:.3f} to {x_max:.3f} along x and "
                f"from {y_min:.3f} to {y_max:.3f} along y [m]"
            )


def place_again(cell: Cell, objects: Sequence[SceneObject], seed: int) -> set[str]:
    """Sample the poses of objects in a built cell with another seed; return their names.

    A `CellError` is raised if there is no free pose.
    """
    later = sampled_objects(objects)
    if later:
        with cell.editing():
            entities = {name: cell.remove(name) for name in later}
            for scene_object in objects:
                if scene_object.name in later:
                    add_object(cell, scene_object, entities[scene_object.name], seed)
    return later


@contextlib.contextmanager
def naming_file(scene: Scene) -> Iterator[None]:
    """Prefix errors with the path of the scene's file, if it was read from one."""
    try:
        yield
    except CellError as error:
        if not scene.source:
            raise
        raise type(error)(f"{scene.source}: {error}") from error
