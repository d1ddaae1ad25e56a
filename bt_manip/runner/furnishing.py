"""Replacing fixtures of a scene by other models."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.cell import as_object, bottom_of
from bt_manip.cell.objects import Catalogue
from bt_manip.models import is_address
from bt_manip.runner.scene import Fixture, Scene, SceneRobot


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
