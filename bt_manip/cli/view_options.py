"""The options of ``bt-manip run`` that views of plugins bring: ``--NAME`` and ``--NAME-KEY``."""

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

_VIEWS = "bt_manip.views"
_BEFORE = ("real_time", "window")
"""Options that ``--help`` lists before the options of views."""


class ViewingCommand(GroupedCommand):
    """A command with the options of views; the chosen views are its argument ``views``.

    ``views`` has the values of each chosen view's options, by the name of the view.

    Args:
        always: Names of views that are chosen without an option.
    """

    def __init__(self, *arguments: Any, always: Collection[str] = (), **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._always = always

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return all options, including the options of views."""
        own = super().get_params(ctx)
        place = 1 + max(i for i, one in enumerate(own) if one.name in _BEFORE)
        views = self._views(ctx, [])
        brought = [one for name, some in views.items() for one in some[name in self._always :]]
        return [*own[:place], *brought, *own[place:]]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the command line, with the options of the views that are installed."""
        views = self._views(ctx, args)
        try:
            rest = super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            if package := missing("option", error.option_name):
                raise click.UsageError(f"{error.option_name} {package}", ctx) from None
            raise
        found: dict[str, Mapping[str, Any]] = {}
        for name, (flag, *others) in views.items():
            values = {one.metavar_key: ctx.params.pop(one.name, None) for one in others}
            if ctx.params.pop(flag.name, name in self._always):
                found[name] = {key: value for key, value in values.items() if value is not None}
        ctx.params["views"] = found
        return rest

    def _views(self, ctx: click.Context, args: list[str]) -> "dict[str, list[_ViewOption]]":
        """Return the options of each view, which are searched once for a command line."""
        if _VIEWS not in ctx.meta:
            from bt_manip.plugins import view_factories

            factories = view_factories(_chosen(ctx, args))
            ctx.meta[_VIEWS] = {name: _options(name, make) for name, make in factories.items()}
        found: dict[str, list[_ViewOption]] = ctx.meta[_VIEWS]
        return found


class _ViewOption(GroupedOption):
    """An option of a view; ``metavar_key`` is the name of the factory's argument."""

    metavar_key = ""
    name: str


def _chosen(ctx: click.Context, args: list[str]) -> "PluginSelection":
    """Return the selected plugins, also for a command line that is not parsed yet."""
    first = plugin_options(click.Command("", add_help_option=False))
    reading = click.Context(first, ignore_unknown_options=True, allow_extra_args=True)
    given, _, _ = first.make_parser(reading).parse_args(list(args))
    folders = [Path(one) for one in given.get("plugins_dir") or () if Path(one).is_dir()]
    return chosen(ctx).extended(given.get("block") or (), folders)


def _options(name: str, make: Callable[..., Any]) -> list[_ViewOption]:
    """Return the options of a view: the flag that opens it, and its parameters."""
    from bt_manip.parameters import parameters_of

    plain = name.replace("_", "-")
    summary = " ".join((make.__doc__ or "").partition("\n\n")[0].split())
    flag = [f"--{plain}", f"view_{_identifier(name)}"]
    options = [_ViewOption(flag, group="Views", is_flag=True, help=summary)]
    for key, parameter in parameters_of(make, keyword_only=True).items():
        option = _ViewOption(
            [f"--{plain}-{key.replace('_', '-')}", f"view_{_identifier(name)}_{key}"],
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


def _identifier(name: str) -> str:
    return name.replace("-", "_")


def _reader(parameter: "Parameter") -> Callable[[click.Context, click.Parameter, Any], Any]:
    def read(ctx: click.Context, option: click.Parameter, value: Any) -> Any:
        try:
            return parameter.read(value) if isinstance(value, str) else value
        except ValueError as error:
            raise click.BadParameter(str(error), ctx, option) from None

    return read
