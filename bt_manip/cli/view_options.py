"""The options that views, modifiers and pools of plugins bring: ``--NAME`` and ``--NAME-KEY``."""

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.options import GroupedCommand, GroupedOption
from bt_manip.cli.plugin_options import chosen, plugin_options
from bt_manip.packages import missing

if TYPE_CHECKING:
    from bt_manip.parameters import Parameter
    from bt_manip.plugins import PluginSelection

_KINDS: Mapping[str, Mapping[str, Any]] = {
    "views": {"group": "Views", "is_flag": True},
    "modifiers": {"group": "Disturbances", "metavar": "TEXT", "multiple": True},
    "pools": {"metavar": "TEXT", "is_flag": False, "flag_value": "local"},
}
"""Attributes of the option ``--NAME`` of each kind of parts."""


class ModifiedCommand(GroupedCommand):
    """A command with the options of parts of plugins.

    For each kind of parts in `brings`, it has an argument of that name with the values of the
    options that are given, by the name of the part; of a view, these are the values of its own
    options, by name.

    Args:
        always: Names of views that are chosen without an option.
    """

    brings: tuple[str, ...] = ("modifiers",)

    def __init__(self, *arguments: Any, always: Collection[str] = (), **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._always = always

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return all options, including those of plugins."""
        brought = (parts for kind in self.brings for parts in _brought(kind, ctx, []).items())
        options = (option for name, some in brought for option in some[name in self._always :])
        return [*super().get_params(ctx), *options]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the command line, with the options of the parts that are installed."""
        brought = {kind: _brought(kind, ctx, args) for kind in self.brings}
        try:
            rest = super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            option = error.option_name
            for kind in self.brings:
                is_view = kind == "views"
                named = ("option", option) if is_view else (kind[:-1], option.removeprefix("--"))
                if package := missing(*named):
                    raise click.UsageError(f"{option} {package}", ctx) from None
            raise
        for kind, parts in brought.items():
            given = ctx.params[kind] = {}
            for name, (first, *others) in parts.items():
                value = ctx.params.pop(first.name, name in self._always)
                values = {one.metavar_key: ctx.params.pop(one.name, None) for one in others}
                if value:
                    known = {key: one for key, one in values.items() if one is not None}
                    given[name] = known if kind == "views" else value
        return rest


class ViewingCommand(ModifiedCommand):
    """A command with the options of views; the chosen views are its argument ``views``.

    ``views`` has the values of each chosen view's options, by the name of the view.

    Args:
        always: Names of views that are chosen without an option.
    """

    brings = ("views",)


class _BroughtOption(GroupedOption):
    """An option of a plugin; ``metavar_key`` is the name of the argument of a view's factory."""

    metavar_key = ""
    name: str


def _brought(kind: str, ctx: click.Context, args: list[str]) -> dict[str, list[_BroughtOption]]:
    """Return the options of each part of a kind, which are searched once for a command line."""
    hook = f"register_{kind}"
    if hook not in ctx.meta:
        from bt_manip.plugins import factories_of

        factories = factories_of(hook, _chosen(ctx, args))
        ctx.meta[hook] = {name: _options(kind, name, make) for name, make in factories.items()}
    found: dict[str, list[_BroughtOption]] = ctx.meta[hook]
    return found


def _chosen(ctx: click.Context, args: list[str]) -> "PluginSelection":
    """Return the selected plugins, also for a command line that is not parsed yet."""
    first = plugin_options(click.Command("", add_help_option=False))
    reading = click.Context(first, ignore_unknown_options=True, allow_extra_args=True)
    given, _, _ = first.make_parser(reading).parse_args(list(args))
    folders = [Path(one) for one in given.get("plugins_dir") or () if Path(one).is_dir()]
    return chosen(ctx).extended(given.get("block") or (), folders)


def _options(kind: str, name: str, make: Callable[..., Any]) -> list[_BroughtOption]:
    """Return the options of a part: the one with its name, and those of a view's parameters."""
    from bt_manip.parameters import parameters_of

    flag, identifier = f"--{name.replace('_', '-')}", f"{kind}_{name.replace('-', '_')}"
    attributes = {key: getattr(make, key, value) for key, value in _KINDS[kind].items()}
    summary = " ".join((make.__doc__ or "").partition("\n\n")[0].split())
    options = [_BroughtOption([flag, identifier], help=summary, **attributes)]
    own = parameters_of(make, keyword_only=True) if kind == "views" else {}
    for key, parameter in own.items():
        option = _BroughtOption(
            [f"{flag}-{key.replace('_', '-')}", f"{identifier}_{key}"],
            help=parameter.described,
            group="Views",
            type=str,  # read by the callback
            metavar=key.upper(),
            default=None if parameter.mandatory else parameter.default,
            show_default=True,
            callback=_reader(parameter),
        )
        option.metavar_key = key
        options.append(option)
    return options


def _reader(parameter: "Parameter") -> Callable[[click.Context, click.Parameter, Any], Any]:
    def read(ctx: click.Context, option: click.Parameter, value: Any) -> Any:
        try:
            return parameter.read(value) if isinstance(value, str) else value
        except ValueError as error:
            raise click.BadParameter(str(error), ctx, option) from None

    return read
