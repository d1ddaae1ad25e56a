"""The options that views and modifiers of plugins bring: ``--NAME`` and ``--NAME-KEY``."""

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from bt_manip.cli.options import GroupedCommand, GroupedOption
from bt_manip.cli.plugin_options import chosen, plugin_options
from bt_manip.packages import missing

if TYPE_CHECKING:
    from bt_manip.parameters import Parameter
    from bt_manip.plugins import PluginSelection

T = TypeVar("T")

_BEFORE = ("real_time", "window")
"""Options that ``--help`` lists before the options of views."""


class ModifiedCommand(GroupedCommand):
    """A command with the options of parts of plugins.

    For each kind of parts in `brings`, it has an argument of that name with the values of the
    options that are given, by the name of the part.
    """

    brings: tuple[str, ...] = ("modifiers",)

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return all options, including those of plugins."""
        brought = [one for kind in self.brings for one in _options_of(kind, ctx, []).values()]
        return [*super().get_params(ctx), *brought]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the command line, with the options of the parts that are installed."""
        brought = {kind: _options_of(kind, ctx, args) for kind in self.brings}
        try:
            rest = super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            for kind in self.brings:
                if package := missing(kind[:-1], error.option_name.removeprefix("--")):
                    raise click.UsageError(f"{error.option_name} {package}", ctx) from None
            raise
        for kind, options in brought.items():
            values = {name: ctx.params.pop(one.name) for name, one in options.items()}
            ctx.params[kind] = {name: value for name, value in values.items() if value}
        return rest


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

    def _views(self, ctx: click.Context, args: list[str]) -> "dict[str, list[_BroughtOption]]":
        """Return the options of each view, which are searched once for a command line."""
        return _brought(ctx, args, "register_views", _options)


class _BroughtOption(GroupedOption):
    """An option of a plugin; ``metavar_key`` is the name of the argument of a view's factory."""

    metavar_key = ""
    name: str


def _brought(
    ctx: click.Context, args: list[str], hook: str, make: Callable[[str, Callable[..., Any]], T]
) -> dict[str, T]:
    """Return a value for each part that plugins register by a hook, made of name and factory."""
    if hook not in ctx.meta:
        from bt_manip.plugins import factories_of

        factories = factories_of(hook, _chosen(ctx, args))
        ctx.meta[hook] = {name: make(name, factory) for name, factory in factories.items()}
    found: dict[str, T] = ctx.meta[hook]
    return found


def _chosen(ctx: click.Context, args: list[str]) -> "PluginSelection":
    """Return the selected plugins, also for a command line that is not parsed yet."""
    first = plugin_options(click.Command("", add_help_option=False))
    reading = click.Context(first, ignore_unknown_options=True, allow_extra_args=True)
    given, _, _ = first.make_parser(reading).parse_args(list(args))
    folders = [Path(one) for one in given.get("plugins_dir") or () if Path(one).is_dir()]
    return chosen(ctx).extended(given.get("block") or (), folders)


def _options(name: str, make: Callable[..., Any]) -> list[_BroughtOption]:
    """Return the options of a view: the flag that opens it, and its parameters."""
    from bt_manip.parameters import parameters_of

    plain = name.replace("_", "-")
    flag = [f"--{plain}", f"view_{_identifier(name)}"]
    options = [_BroughtOption(flag, group="Views", is_flag=True, help=_summary(make))]
    for key, parameter in parameters_of(make, keyword_only=True).items():
        option = _BroughtOption(
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


def _options_of(kind: str, ctx: click.Context, args: list[str]) -> dict[str, _BroughtOption]:
    """Return the option of each modifier or pool, which are searched once for a command line."""
    several = kind == "modifiers"
    how: Any = {"multiple": True} if several else {"is_flag": False, "flag_value": "local"}

    def option(name: str, make: Callable[..., Any]) -> _BroughtOption:
        names = [f"--{name.replace('_', '-')}", f"{kind}_{_identifier(name)}"]
        metavar = getattr(make, "metavar", "TEXT")
        group = getattr(make, "group", "Disturbances") if several else ""
        return _BroughtOption(names, metavar=metavar, group=group, help=_summary(make), **how)

    return _brought(ctx, args, f"register_{kind}", option)


def _summary(make: Callable[..., Any]) -> str:
    return " ".join((make.__doc__ or "").partition("\n\n")[0].split())


def _identifier(name: str) -> str:
    return name.replace("-", "_")


def _reader(parameter: "Parameter") -> Callable[[click.Context, click.Parameter, Any], Any]:
    def read(ctx: click.Context, option: click.Parameter, value: Any) -> Any:
        try:
            return parameter.read(value) if isinstance(value, str) else value
        except ValueError as error:
            raise click.BadParameter(str(error), ctx, option) from None

    return read
