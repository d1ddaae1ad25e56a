"""Options of commands as fields of dataclasses: each is declared once for all commands."""

import functools
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import Field, dataclass, field, fields
from typing import Any, TypeVar

import click

from bt_manip.cli.completion import complete_key, complete_part

Function = TypeVar("Function", bound=Callable[..., Any])


class GroupedOption(click.Option):
    """An option with the group under which ``--help`` lists it; empty: the others."""

    def __init__(self, *names: Any, group: str = "", **attributes: Any) -> None:
        super().__init__(*names, **attributes)
        self.group = group


class GroupedCommand(click.Command):
    """A command whose ``--help`` lists its options in groups, each in the order of declaration."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, a section for each group; those without one come last."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for one in self.get_params(ctx):
            record = one.get_help_record(ctx) if isinstance(one, click.Option) else None
            if record is not None:
                groups.setdefault(getattr(one, "group", ""), []).append(record)
        rest = groups.pop("", [])
        for title, records in (*groups.items(), ("Options", rest)):
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


def option(*names: str, group: str = "", **attributes: Any) -> Any:
    """Declare a field of a dataclass as an option of commands, with arguments of `click.option`."""
    attributes |= {"cls": GroupedOption, "group": group}
    none = () if attributes.get("multiple") else False if attributes.get("is_flag") else None
    return field(default=attributes.get("default", none), metadata={"option": (names, attributes)})


def options_of(kind: type) -> Any:
    """Declare a field whose value is another dataclass of options."""
    return field(default_factory=kind, metadata={"options": kind})


def takes(
    kind: type, *, name: str = "options", only: Collection[str] = (), without: Collection[str] = ()
) -> Callable[[Function], Function]:
    """Add the options of a dataclass to a command, which gets them as one argument.

    An argument of the command with the name of a field is part of it.

    Args:
        kind: The dataclass.
        name: Name of the command's argument.
        only: Names of the fields that the command has; empty: all.
        without: Names of fields that it does not have.
    """

    def decorate(command: Function) -> Function:
        @functools.wraps(command)
        def with_options(*args: Any, **given: Any) -> Any:
            made = _take(kind, given)
            return command(*args, **{name: made}, **given)

        for one in reversed(list(_declared(kind))):
            if (not only or one.name in only) and one.name not in without:
                names, attributes = one.metadata["option"]
                click.option(*names, one.name, **attributes)(with_options)
        return with_options  # type: ignore[return-value]

    return decorate


def given_options(options: Any) -> Iterator[list[str]]:
    """Yield the words of each given option, as on the command line: its name, then its values."""
    for one in fields(options):
        value = getattr(options, one.name)
        if "options" in one.metadata:
            yield from given_options(value)
        elif "option" in one.metadata and value != one.default:
            (name, *_), attributes = one.metadata["option"]
            if isinstance(value, Mapping):
                value = [f"{key}={text}" for key, text in value.items()]
            for each in value if attributes.get("multiple") else [value]:
                values = each if isinstance(each, tuple) else [each]
                yield [name] if attributes.get("is_flag") else [name, *map(str, values)]


def _declared(kind: type) -> Iterator[Field[Any]]:
    for one in fields(kind):
        if "option" in one.metadata:
            yield one
        elif "options" in one.metadata:
            yield from _declared(one.metadata["options"])


def _take(kind: type, given: dict[str, Any]) -> Any:
    """Make a dataclass from the given values that are its fields, and remove them."""
    taken = {
        one.name: _take(one.metadata["options"], given)
        for one in fields(kind)
        if "options" in one.metadata
    }
    taken |= {one.name: given.pop(one.name) for one in fields(kind) if one.name in given}
    return kind(**taken)


def _settings(
    context: click.Context, parameter: click.Parameter, texts: Collection[str]
) -> Mapping[str, str]:
    """Split settings ``KEY=VALUE`` into keys and values; a value may hold further ``=``."""
    settings: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise click.UsageError(f"--set wants KEY=VALUE, got '{text}'")
        if key.strip() in settings:
            raise click.UsageError(f"--set gives '{key.strip()}' twice")
        settings[key.strip()] = value
    return settings


@dataclass(frozen=True)
class StationOptions:
    """The parts of a station, and the settings of its tree."""

    robot: str = option(
        "--robot", group="Cell and robot", default="panda", show_default=True, metavar="R",
        shell_complete=complete_part("robots"),
        help="Robot to use: a registered name, or path.toml that describes one.",
    )  # fmt: skip
    controller: str | None = option(
        "--controller", group="Cell and robot",
        metavar="C", shell_complete=complete_part("controllers"),
        help="Controller of the arm.  [default: the tree's, or computed_torque]",
    )  # fmt: skip
    scene: str | None = option(
        "--scene", group="Cell and robot", metavar="S", shell_complete=complete_part("scenes"),
        help="Robots and objects in the cell: a registered name, or path.toml.  [default: the "
        "tree's, or table_and_basket]",
    )  # fmt: skip
    planner: str = option(
        "--planner", group="Cell and robot", default="rrt_connect", show_default=True, metavar="P",
        shell_complete=complete_part("planners"), help="Planner of collision-free paths.",
    )  # fmt: skip
    tool_speed: float | None = option(
        "--tool-speed", group="Cell and robot",
        type=click.FloatRange(min=0.0, min_open=True), metavar="V",
        help="Maximum speed of the tool in every motion [m/s]; inf: no limit.  [default: the "
        "scene's or the robot's; else 0.25 on a real robot, inf in simulation]",
    )  # fmt: skip
    poses: str | None = option(
        "--poses", group="Cell and robot",
        metavar="P", shell_complete=complete_part("pose_sources"),
        help="Where objects are: physics spawns them; scene takes those that the scene expects, "
        "operator asks for each of them (see: bt-manip list pose_sources).  [default: operator on "
        "a real robot, else physics]",
    )  # fmt: skip
    settings: Mapping[str, str] | tuple[()] = option(
        "--set", group="Task", multiple=True, callback=_settings, metavar="KEY=VALUE",
        shell_complete=complete_key,
        help="Set a key that the tree declares; may be given more than once.",
    )  # fmt: skip
    strict: bool = option(
        "--strict", group="Task", is_flag=True,
        help="Refuse trees of which the checks before the run warn.",
    )  # fmt: skip

    @property
    def request_fields(self) -> dict[str, Any]:
        """The options by the fields of `bt_manip.runner.RunRequest`; None: the default."""
        found = {one.name: getattr(self, one.name) for one in fields(StationOptions)}
        found |= {"settings": dict(self.settings)}
        if found.pop("strict"):
            from bt_manip.bt import ReadingOptions

            found["reading"] = ReadingOptions(dialect="auto", fatal_warnings=True)
        return found


VARY: Mapping[str, Any] = {
    "multiple": True,
    "metavar": "KEY=VALUE",
    "help": "Set a parameter that bt-manip sweep varies, such as controller.kp, "
    "scene.objects.cube.mass, or scene.mass, a level of bt-manip list tasks TREE; may be given "
    "more than once.",
}
"""The option ``--vary`` of commands that give each parameter one value."""


def vary_option(command: Function) -> Function:
    """Add ``--vary`` to a command."""
    return click.option("--vary", "varied", **VARY)(command)


def workers_option(command: Function) -> Function:
    """Add ``--workers`` to a command."""
    return click.option(
        "--workers", type=click.IntRange(min=1), metavar="N",
        help="Number of processes, or of workers on a cluster.  [default: one for each core]",
    )(command)  # fmt: skip
