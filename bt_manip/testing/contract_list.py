"""List of the contract checks of a plugin's parts."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from bt_manip.bt.nodes import Leaf
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Parts
from bt_manip.testing.behaviour_contract import BEHAVIOUR_CONTRACT, BehaviourCase, Example
from bt_manip.testing.controller_contract import CONTROLLER_CONTRACT, ControllerCase
from bt_manip.testing.object_contract import OBJECT_CONTRACT, ObjectCase
from bt_manip.testing.robot_contract import ROBOT_CONTRACT, RobotCase
from bt_manip.testing.situations import Situations
from bt_manip.testing.tree_runs import run_tree

if TYPE_CHECKING:
    from bt_manip.plugins import Plugin, Plugins


class Check(NamedTuple):
    """One check of one part."""

    id: str
    run: Callable[[Situations], None]


def checks_of(
    plugins: "Plugins",
    name: str,
    *,
    examples: Mapping[str, Example],
    parameters: Mapping[str, Mapping[str, Any]],
    without: tuple[str, ...] = (),
) -> list[Check]:
    """Return the checks of all parts of a plugin.

    Args:
        plugins: All plugins.
        name: Name of the plugin.
        examples: Examples of behaviours, by name.
        parameters: Parameters of objects, by name.
        without: Names of parts, or ``"part: check"``, to leave out.

    Raises:
        BtManipError: When the plugin is unknown or broken, or an example names no part.
    """
    plugin = find_plugin(plugins, name)
    brought = plugin.provides
    for kind, given in (("behaviours", examples), ("objects", parameters)):
        for part in given:
            if part not in brought.get(kind, ()):
                raise BtManipError(
                    f"plugin '{name}' has no '{part}' among its {kind}"
                    + did_you_mean(part, brought.get(kind, ()))
                )
    checks = [
        *_objects(plugins.parts, brought.get("objects", ()), parameters),
        *_robots(plugins.parts, brought.get("robots", ())),
        *_controllers(plugins.parts, brought.get("controllers", ())),
        *_behaviours(plugins.parts, brought.get("behaviours", ()), examples),
    ]
    left_out = {c.id for c in checks if c.id in without or c.id.partition(":")[0] in without}
    return [check for check in checks if check.id not in left_out]


def find_plugin(plugins: "Plugins", name: str) -> "Plugin":
    """Return a working plugin.

    Raises:
        BtManipError: When it is unknown or broken.
    """
    known = {plugin.name: plugin for plugin in plugins.plugins}
    if name not in known:
        raise BtManipError(f"no plugin '{name}'{did_you_mean(name, known)}")
    if known[name].problem:
        raise BtManipError(known[name].warning)
    return known[name]


def tree_runs(plugins: "Plugins", where: str | Path, options: Mapping[str, Any]) -> list[Any]:
    """Return the runs of all trees of a plugin or a folder, as ``(name, run(parts, coverage))``.

    Raises:
        BtManipError: When there are no trees, or an end state names no tree.
    """
    if Path(where).is_dir():
        trees = {path.stem: str(path) for path in sorted(Path(where).glob("*.xml"))}
    else:
        names = find_plugin(plugins, str(where)).provides.get("trees", ())
        trees = {name: name for name in names}
    if not trees:
        raise BtManipError(f"'{where}' has no trees")
    for key in ("end_states", "settings"):
        for name in options[key]:
            if name not in trees:
                raise BtManipError(f"'{where}' has no tree '{name}'{did_you_mean(name, trees)}")

    def run(place: str, name: str, parts: Parts, coverage: Any) -> None:
        run_tree(
            place, parts, end_state=options["end_states"].get(name), coverage=coverage,
            settings=options["settings"].get(name), **options["run"],
        )  # fmt: skip

    return [(name, partial(run, place, name)) for name, place in trees.items()]


def _objects(
    parts: Parts, names: tuple[str, ...], parameters: Mapping[str, Mapping[str, Any]]
) -> Iterator[Check]:
    for name in names:
        case = ObjectCase(name, parts.objects.get(name), parameters.get(name, {}))
        yield from (_check(name, check, case) for check in OBJECT_CONTRACT)


def _robots(parts: Parts, names: tuple[str, ...]) -> Iterator[Check]:
    for name in names:
        description = parts.robots.get(name)
        kind = description.gripper.kind if description.gripper is not None else None
        case = RobotCase(description, *([] if kind is None else [parts.grippers.get(kind)]))
        yield from (_check(name, check, case) for check in ROBOT_CONTRACT)


def _controllers(parts: Parts, names: tuple[str, ...]) -> Iterator[Check]:
    for name in names:
        case = ControllerCase(name, parts.controllers.get(name))
        yield from (_check(name, check, case) for check in CONTROLLER_CONTRACT)


def _behaviours(
    parts: Parts, names: tuple[str, ...], examples: Mapping[str, Example]
) -> Iterator[Check]:
    for name in names:
        cls = parts.behaviours.get(name)
        if not issubclass(cls, Leaf):
            continue  # control nodes and decorators have no life cycle of their own
        example = examples.get(name)
        if example is None:
            example = Example()
            missing = [p.name for p in cls.ports.values() if p.mandatory]
            if missing:
                yield Check(f"{name}: has an example", partial(_no_example, name, missing))
                continue
        for check in BEHAVIOUR_CONTRACT:
            yield Check(f"{name}: {_title(check)}", partial(_run, check, cls, example))


def _check(name: str, check: Callable[[Any], None], case: Any) -> Check:
    return Check(f"{name}: {_title(check)}", lambda situations: check(case))


def _run(
    check: Callable[[BehaviourCase], None], cls: type, example: Example, situations: Situations
) -> None:
    check(BehaviourCase(cls, example, situations))


def _no_example(name: str, missing: list[str], situations: Situations) -> None:
    ports = ", ".join(f'"{port}": ...' for port in missing)
    raise AssertionError(
        f"give an example of how {name} is used: examples={{'{name}': Example({{{ports}}})}}"
    )


def _title(check: Callable[..., None]) -> str:
    return check.__name__.replace("_", " ")
