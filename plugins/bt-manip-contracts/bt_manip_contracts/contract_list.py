"""List of the contract checks of a plugin's parts."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from bt_manip.bt import Action, Condition
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.plugins import Plugins
from bt_manip.registry import Parts
from bt_manip.testing import Check, Situations
from bt_manip_contracts.behaviour_contract import BEHAVIOUR_CONTRACT, BehaviourCase, Example
from bt_manip_contracts.condition_contract import CONDITION_CONTRACT, forgets_earlier_cycles
from bt_manip_contracts.controller_contract import CONTROLLER_CONTRACT, ControllerCase
from bt_manip_contracts.object_contract import OBJECT_CONTRACT, ObjectCase
from bt_manip_contracts.robot_contract import ROBOT_CONTRACT, RobotCase
from bt_manip_contracts.run_contract import RUN_CONTRACT, SHORT_RUN_CONTRACT, RunCase

EXERCISE = "bt_manip_contracts.exercise:exercise"
"""Tree by which scenes are checked."""


def checks_of(
    plugins: Plugins,
    name: str,
    *,
    examples: Mapping[str, Example],
    parameters: Mapping[str, Mapping[str, Any]],
    settings: Mapping[str, Mapping[str, Any]],
    without: tuple[str, ...] = (),
) -> list[Check]:
    """Return the checks of all parts of a plugin; the arguments are those of `contracts_of`.

    Raises:
        BtManipError: When the plugin is unknown or broken, or an example names no part.
    """
    brought = plugins.working(name).provides
    for kind, given in (("behaviours", examples), ("objects", parameters), ("trees", settings)):
        for part in given:
            if part not in brought.get(kind, ()):
                raise BtManipError(
                    f"plugin '{name}' has no '{part}' among its {kind}"
                    + did_you_mean(part, brought.get(kind, ()))
                )
    checks = [
        *_checks(plugins.parts, brought, examples, parameters),
        *_run_checks(plugins.parts, brought, settings),
    ]
    for contract in plugins.parts.contracts:
        checks += plugins.parts.contracts.get(contract)(plugins.parts, brought, settings)
    left_out = {c.id for c in checks if c.id in without or c.id.partition(":")[0] in without}
    return [check for check in checks if check.id not in left_out]


def _checks(
    parts: Parts,
    brought: Mapping[str, tuple[str, ...]],
    examples: Mapping[str, Example],
    parameters: Mapping[str, Mapping[str, Any]],
) -> Iterator[Check]:
    for name in brought.get("objects", ()):
        case = ObjectCase(name, parts.objects.get(name), parameters.get(name, {}))
        yield from _each(name, OBJECT_CONTRACT, _given(case))
    for name in brought.get("robots", ()):
        description = parts.robots.get(name)
        kind = description.gripper.kind if description.gripper is not None else None
        grippers = [] if kind is None else [parts.grippers.get(kind)]
        yield from _each(name, ROBOT_CONTRACT, _given(RobotCase(description, *grippers)))
    for name in brought.get("controllers", ()):
        controller = ControllerCase(name, parts.controllers.get(name))
        yield from _each(name, CONTROLLER_CONTRACT, _given(controller))
    for name in brought.get("behaviours", ()):
        cls = parts.behaviours.get(name)
        if not issubclass(cls, Action | Condition):
            continue  # control nodes and decorators have no life cycle of their own
        missing = [p.name for p in cls.ports.values() if p.mandatory]
        if missing and name not in examples:
            yield Check(f"{name}: has an example", partial(_no_example, name, missing))
            continue
        example = examples.get(name, Example())
        yield from _each(name, BEHAVIOUR_CONTRACT, partial(BehaviourCase, cls, example))
        if issubclass(cls, Condition):
            placed = getattr(cls, "destination", "")
            checks = (forgets_earlier_cycles, *(CONDITION_CONTRACT if placed else ()))
            yield from _each(name, checks, partial(BehaviourCase, cls, example))


def _run_checks(
    parts: Parts,
    brought: Mapping[str, tuple[str, ...]],
    settings: Mapping[str, Mapping[str, Any]],
) -> Iterator[Check]:
    """Yield the checks of runs: same bits in any order and from any state."""
    for name in brought.get("robots", ()):
        run = RunCase(name, "pick_place", parts, {"robot": name})
        yield from _each(name, RUN_CONTRACT, _given(run), long=True)
    for name in brought.get("scenes", ()):
        make = partial(_scene_case, name, parts)
        yield from _each(f"scene {name}", SHORT_RUN_CONTRACT, make)
        yield from _each(f"scene {name}", RUN_CONTRACT, make, long=True)
    for name in brought.get("trees", ()):
        title = f"tree {name}"
        options = {"settings": {key: str(value) for key, value in settings.get(name, {}).items()}}
        run = RunCase(title, name, parts, options)
        yield from _each(title, SHORT_RUN_CONTRACT, _given(run))
        yield from _each(title, RUN_CONTRACT, _given(run), long=True)


def _scene_case(name: str, parts: Parts, situations: Situations) -> RunCase:
    robots = ";".join(robot.name for robot in parts.scenes.create(name).robots)
    options = {"scene": name, "settings": {"robots": robots}}
    return RunCase(f"scene {name}", EXERCISE, parts, options)


def _given(case: Any) -> Callable[[Situations], Any]:
    return lambda situations: case


def _each(
    name: str,
    contract: tuple[Callable[[Any], None], ...],
    make_case: Callable[[Situations], Any],
    *,
    long: bool = False,
) -> Iterator[Check]:
    def run(check: Callable[[Any], None], situations: Situations) -> None:
        check(make_case(situations))

    for check in contract:
        title = check.__name__.replace("_", " ")
        yield Check(f"{name}: {title}", partial(run, check), long)


def _no_example(name: str, missing: list[str], situations: Situations) -> None:
    ports = ", ".join(f'"{port}": ...' for port in missing)
    raise AssertionError(
        f"give an example of how {name} is used: examples={{'{name}': Example({{{ports}}})}}"
    )
