"""Checks of a robot description; each finding names a key and the change to make."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.collision import CollisionWorld, permanent_self_collisions, self_collisions
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Parts
from bt_manip.robots import (
    Gripper,
    Robot,
    RobotDescription,
    RobotModel,
    element_names,
    read_description,
    read_gripper,
    read_model,
)
from bt_manip_contracts import ROBOT_CONTRACT

from .inspection import ReachMap, compiled, reach_map, robot_case, tool_findings
from .joint_data import light_joints
from .reach import GRASP_HEIGHT
from .trial import CYCLES, Checked, try_robot

_CUBE = 0.1  # [kg] least payload: twice the cube of the pick and place task
_PARTS = {"joints": ("joint",), "fingers": ("body",), "motor": ("joint", "tendon")}


def check_description(
    path: Path,
    parts: Parts,
    cycles: int = CYCLES,
    report: Callable[[str], None] = lambda _: None,
) -> Checked:
    """Check a description file: its keys, its names, and the resulting robot.

    A robot with a gripper and without findings is then tried, by `try_robot`.

    Args:
        path: The TOML file.
        parts: The registered parts.
        cycles: Number of cycles of the pick and place task in the trial; 0: no trial.
        report: Called with the present step of the trial.
    """
    findings = _wrong_keys(path, parts)
    if not findings:
        description = read_description(path)
        findings = list(_unknown_names(description))
    if findings:
        return Checked(findings, [])
    try:
        case = robot_case(description, parts)
        robot = compiled(case)
    except BtManipError as error:
        return Checked([str(error), *tool_findings(description)], [])
    findings += _home_findings(robot)
    findings += tool_findings(description)
    model = robot.make_model()
    reached = reach_map(robot, model)
    findings += _reach_findings(description, reached)
    facts = [*robot.warnings, *reached.lines(), *_light_joints(description, model)]
    try:
        case.stand()
    except BtManipError as error:
        finding = f"{description.where}: key 'base': {error}; raise its position"
        return Checked([*findings, finding], facts)
    for check in ROBOT_CONTRACT:
        try:
            check(case)
        except AssertionError as failed:
            key, remedy = _REMEDIES[check.__name__]
            findings.append(f"{description.where}: key '{key}': {failed}; {remedy}")
    if cycles and description.gripper is not None and not findings:
        trial = try_robot(description, parts, cycles, report)
        findings, facts = [*findings, *trial.findings], [*facts, *trial.facts]
    return Checked(findings, facts, robot)


def _light_joints(description: RobotDescription, model: RobotModel) -> Iterator[str]:
    """Yield a line about joints with too little inertia for precise feedback."""
    light = light_joints(model)
    names = [name for name, one in zip(description.arm_joints, light, strict=True) if one]
    if names:
        yield (
            f"almost no inertia: {', '.join(names)}; give 'armature', the rotor inertia of the "
            "motors times the gear ratio squared [kg m2]"
        )


_REMEDIES = {
    "its_model_agrees_with_mujoco": (
        "arm_joints",
        "joints that the model couples do not form an arm",
    ),
    "it_reaches_what_it_can_reach": ("tolerance", "allow more, if the model's numbers are rounded"),
    "it_stands_still_at_home": ("effort", "check it, and 'exclude' for bodies that touch"),
    "its_gripper_opens_and_closes": (
        "gripper",
        "check its joints, motor and max_force; frictionloss = 0.0 replaces the model's friction",
    ),
    "its_gripper_continues_from_its_state": ("gripper.kind", "this kind has to save its state"),
}


def _wrong_keys(path: Path, parts: Parts) -> list[str]:
    """Return all errors in the file, including those of gripper parameters."""
    found: list[str] = []
    for read in (lambda: read_description(path), lambda: _read_parameters(path, parts)):
        try:
            read()
        except BtManipError as error:
            found += str(error).splitlines()
    return list(dict.fromkeys(found))


def _read_parameters(path: Path, parts: Parts) -> None:
    gripper = read_gripper(path)
    if gripper is not None:
        kind = parts.grippers.get(gripper.kind)
        if isinstance(kind, type) and issubclass(kind, Gripper):
            kind.check_parameters(gripper.read(path.stem))


def _unknown_names(description: RobotDescription) -> Iterator[str]:
    """Yield an error for each missing model, and for each name that the models lack."""
    where, gripper = description.where, description.gripper
    models = [description.model, gripper.model if gripper else None]
    roots, errors = [], []
    for model in filter(None, models):
        try:
            roots.append(read_model(model, where)[0])
        except BtManipError as error:
            errors.append(str(error))
    if errors:
        yield from errors
        return
    arm, both, hand = roots[:1], roots, roots[-1:]
    excluded = [name for pair in description.exclude for name in pair if name != "pedestal"]
    wanted: list[tuple[str, Sequence[str], tuple[str, ...], list[Any]]] = [
        ("arm_joints", description.arm_joints, ("joint",), arm),
        ("tool.frame", [description.tool_frame], ("site", "body"), both),
        ("exclude", excluded, ("body",), both),
        ("convex_parts", description.convex_parts, ("body",), both),
    ]
    if gripper is not None:
        mounts = [gripper.mount] if gripper.mount else []
        wanted.append(("gripper.mount", mounts, ("site", "body"), arm))
        for key, kinds in _PARTS.items():
            names = gripper.parameters.get(key, ())
            names = [names] if isinstance(names, str) else names
            wanted.append((f"gripper.{key}", names, kinds, hand))
    for key, names, kinds, searched in wanted:
        known = {one for root in searched for kind in kinds for one in element_names(root, kind)}
        for name in names:
            if name not in known and name.rpartition("/")[2] not in known:
                what = f"there is no {' or '.join(kinds)} '{name}'{did_you_mean(name, known)}"
                yield f"{where}: key '{key}': {what}"


def _home_findings(robot: Robot) -> Iterator[str]:
    world = CollisionWorld(robot, robot.make_model())
    collisions = self_collisions(world, np.array(robot.description.home))
    permanent = permanent_self_collisions(world) if collisions else []
    for first, second, depth in collisions:
        always = (first, second) in permanent
        remedy = f'add ["{first}", "{second}"] to it' if always else "choose another home"
        often = "in every configuration" if always else "at home"
        yield (
            f"{robot.description.where}: key '{'exclude' if always else 'home'}': '{first}' is "
            f"{1e3 * depth:.1f} mm inside '{second}' {often}; {remedy}"
        )


def _reach_findings(description: RobotDescription, reached: ReachMap) -> Iterator[str]:
    if reached.below_tool >= GRASP_HEIGHT:
        yield (
            f"{description.where}: key 'tool': the open gripper reaches "
            f"{1e3 * reached.below_tool:.0f} mm below it, and it grips the cube of pick_place "
            f"{1e3 * GRASP_HEIGHT:.0f} mm over the table; put it nearer to the fingertips"
        )
    elif not reached.reached.any():
        yield (
            f"{description.where}: key 'base': the tool, pointing down, reaches no part of the "
            "table; change position or pedestal, or the tool's z axis"
        )
    elif reached.gripped < _CUBE:
        yield (
            f"{description.where}: key 'gripper.max_force': the grip holds {reached.gripped:.2g} "
            "kg at a friction of 1; give more, if the gripper has it"
        )
    elif reached.payload < _CUBE:
        yield (
            f"{description.where}: key 'effort': the arm holds {reached.payload:.2g} kg at its "
            "tool; check the effort limits, here or in the model"
        )
