"""Discovery, checks and loading of plugins.

pluggy does not isolate plugins: an import error or exception in one of them stops all others, and
misspelt hooks are not reported. Here each plugin is loaded, checked and called separately, and its
parts are registered only after all of its hooks have returned. After a failure, nothing of the
plugin is registered, and one warning names it. All plugins are imported before any hook is called,
because plugins may implement hooks that others declare.
"""

import contextlib
import inspect
import sys
import traceback
import warnings
from collections.abc import Callable, Iterable
from dataclasses import replace
from importlib.metadata import EntryPoint
from importlib.metadata import version as version_of
from types import FrameType, ModuleType
from typing import Any

import pluggy

from bt_manip import hookspecs
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.packages import suggestion
from bt_manip.plugins.declared_hooks import declare_hooks
from bt_manip.plugins.entry_points import (
    PluginPoint,
    PluginSelection,
    block_names,
    in_folders,
    installed,
)
from bt_manip.plugins.plugin import BUILTIN, Implementation, Plugin, Plugins, PluginWarning
from bt_manip.plugins.registrar import Registrar
from bt_manip.registry import Parts

Hooks = dict[str, Callable[..., None]]


def load_plugins(
    *,
    entry_points: Iterable[PluginPoint | EntryPoint] | None = None,
    builtin: object | None = None,
    warn: Callable[[str], None] | None = None,
    choice: PluginSelection | None = None,
) -> Plugins:
    """Load the built-in plugin and all installed plugins that are not blocked.

    Args:
        entry_points: The plugins to load besides the built-in one; default: all installed in the
            group ``bt_manip``.
        builtin: Replacement of the built-in plugin, for tests.
        warn: Called with one line for each broken plugin; default: `warnings.warn` with a
            `PluginWarning`.
        choice: Blocked plugins, and folders with further plugins; default: from the environment
            variables ``BT_MANIP_BLOCK`` and ``BT_MANIP_PLUGINS_DIR``.

    Returns:
        The parts of all working plugins, and every plugin with its parts or its problem.

    Raises:
        BtManipError: If a plugin folder does not exist.
    """
    if warn is None:
        warn = _warn
    if builtin is None:
        from bt_manip import builtin as built_in_plugin

        builtin = built_in_plugin
    if entry_points is None:
        entry_points = installed()
    if choice is None:
        choice = PluginSelection.from_environment()
    points = sorted(entry_points, key=lambda p: (p.name, p.value))
    points += in_folders(choice.folders)
    parts = Parts()
    hooks = {name: getattr(hookspecs, name) for name in hookspecs.REGISTERING + hookspecs.OBSERVING}
    plugins = [_builtin(builtin, parts, hooks)]
    taken = {BUILTIN}
    imported = []
    for point in points:
        found = _found(point)
        found = replace(found, blocked=choice.blocks(block_names(found.name, found.package)))
        imported.append(
            (found, None) if found.blocked else _import(point, found, parts, hooks, taken)
        )
    for found, module in imported:
        plugin = found if found.status != "ok" else _register(found, module, parts, hooks)
        plugins.append(plugin)
        if plugin.problem:
            warn(plugin.warning)
        elif plugin.status == "ok" and plugin.name != BUILTIN:
            parts.plugins[plugin.name] = plugin.version
    for registry in parts.by_kind().values():
        registry.note = _missing(plugins)
    return Plugins(parts, tuple(plugins))


def _warn(message: str) -> None:
    warnings.warn(message, PluginWarning, stacklevel=3)


def _missing(plugins: Iterable[Plugin]) -> str:
    """Describe broken and blocked plugins, for errors about unknown parts."""
    broken = [f"'{p.name}'" for p in plugins if p.status == "broken"]
    blocked = [f"'{p.name}'" for p in plugins if p.status == "blocked"]
    note = f" (left out because broken: plugin {', '.join(broken)})" if broken else ""
    return note + (f" (blocked: plugin {', '.join(blocked)})" if blocked else "")


def _builtin(plugin: object, parts: Parts, hooks: Hooks) -> Plugin:
    """Collect the built-in parts; errors in them are bugs and are not caught."""
    version = version_of("bt-manip")
    registrar = Registrar(BUILTIN, parts)
    observers = _call_hooks(plugin, registrar, hooks)
    provides, module = registrar.merge(), _module_of(plugin)
    source = _file_of(plugin)
    return Plugin(BUILTIN, version, source, provides, observers, module=module, package="bt-manip")


def _import(
    point: PluginPoint | EntryPoint, found: Plugin, parts: Parts, hooks: Hooks, taken: set[str]
) -> tuple[Plugin, object | None]:
    """Import one plugin, and add the hooks that it declares; after a failure, it has a problem."""
    try:
        if point.name in taken:
            raise BtManipError("another plugin has the same name")
        taken.add(point.name)
        # The output of a plugin must not mix with the output of the command.
        with contextlib.redirect_stdout(sys.stderr):
            plugin = point.load()
            found = replace(found, source=_file_of(plugin) or found.source)
            declare_hooks(plugin, parts, hooks)
        return found, plugin
    except (Exception, SystemExit) as error:
        return replace(found, problem=_describe(error)), None


def _register(found: Plugin, plugin: object, parts: Parts, hooks: Hooks) -> Plugin:
    """Register the parts of one plugin; after a failure, it has a problem and no parts."""
    registrar = Registrar(found.name, parts)
    try:
        with contextlib.redirect_stdout(sys.stderr):
            observers = _call_hooks(plugin, registrar, hooks)
        return replace(found, provides=registrar.merge(), observers=observers)
    except (Exception, SystemExit) as error:
        return replace(found, problem=_describe(error))


def _call_hooks(plugin: object, registrar: Registrar, hooks: Hooks) -> tuple[Implementation, ...]:
    """Call the registering hooks of a plugin; return its observing ones."""
    observers = []
    for found in _implementations(plugin, hooks):
        if found.name in hookspecs.OBSERVING:
            observers.append(found)
        else:
            check = getattr(hooks[found.name], "check", None)
            register = registrar.register(found.name.removeprefix("register_"), check)
            found.function(**{argument: register for argument in found.arguments})
    return tuple(observers)


def _implementations(plugin: object, hooks: Hooks) -> list[Implementation]:
    """Return the hook implementations of a plugin, in the order of the specifications.

    Raises a `BtManipError` for hooks that are misspelt, are called otherwise or wrap others, and if
    there is none.
    """
    manager = pluggy.PluginManager(hookspecs.GROUP)
    found, optional = [], False
    for attribute in dir(plugin):
        options = manager.parse_hookimpl_opts(plugin, attribute)
        if options is None:
            continue
        name = options.get("specname") or attribute
        if name in hookspecs.RENAMED:
            raise BtManipError(f"the hook '{name}' is now called '{hookspecs.RENAMED[name]}'")
        if name not in hooks and options.get("optionalhook"):
            optional = True
            continue
        if name not in hooks:
            raise BtManipError(f"there is no hook '{name}'{suggestion('hook', name, hooks)}")
        if options.get("wrapper") or options.get("hookwrapper"):
            raise BtManipError(f"'{name}' wraps other plugins' hooks; hooks only register")
        function = getattr(plugin, attribute)
        _check_function(hooks[name], name, function)
        found.append(Implementation(name, function, tuple(_taken(function))))
    if not found and not optional:
        raise BtManipError("it implements no hook; mark its functions with bt_manip.hookimpl")
    return sorted(found, key=lambda one: [*hooks].index(one.name))


def _check_function(hook: Callable[..., None], name: str, function: Callable[..., Any]) -> None:
    """Raise an error if a function cannot be called as a hook."""
    if inspect.isgeneratorfunction(function) or inspect.isasyncgenfunction(function):
        raise BtManipError(f"'{name}' has a yield in it; a hook is a plain function")
    if inspect.iscoroutinefunction(function):
        raise BtManipError(f"'{name}' is async; a hook is a plain function")
    offered = tuple(inspect.signature(hook).parameters)
    taken = _taken(function)
    for argument in taken:
        if argument not in offered:
            what = did_you_mean(argument, offered)
            raise BtManipError(f"'{name}' is not given '{argument}', which it takes{what}")
    if name not in hookspecs.OBSERVING and not taken:
        raise BtManipError(f"'{name}' does not take 'register', which it is called with")


def _taken(function: Callable[..., Any]) -> list[str]:
    """Return the names of a function's required arguments."""
    return [
        name
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.default is parameter.empty
        and parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
    ]


def _found(point: PluginPoint | EntryPoint) -> Plugin:
    """Return the description of an unloaded plugin."""
    metadata = None if point.dist is None else point.dist.metadata  # which is parsed each time
    version, package = ("", "") if metadata is None else (metadata["Version"], metadata["Name"])
    return Plugin(point.name, version, point.value, module=point.module, package=package)


def _file_of(plugin: object) -> str:
    """Return the file of a plugin, or an empty string."""
    if not isinstance(plugin, ModuleType):
        plugin = sys.modules.get(_module_of(plugin))
    return str(getattr(plugin, "__file__", None) or "")


def _module_of(plugin: object) -> str:
    if isinstance(plugin, ModuleType):
        return plugin.__name__
    return str(getattr(plugin, "__module__", ""))


def _describe(error: BaseException) -> str:
    """Describe an error in one line, with the line of the plugin's code if known."""
    text = " ".join(str(error).split())
    lines = [(f, n) for f, n in traceback.walk_tb(error.__traceback__) if _foreign(f)]
    where = f", at {lines[-1][0].f_code.co_filename}:{lines[-1][1]}" if lines else ""
    if isinstance(error, SyntaxError):
        where = f", at {error.filename}:{error.lineno}" if error.filename else ""
    if isinstance(error, BtManipError):
        return f"{text}{where}"
    return f"{type(error).__name__}: {text}".removesuffix(": ") + where


def _foreign(frame: FrameType) -> bool:
    """Return whether a frame belongs neither to bt-manip nor to Python's import system."""
    module = str(frame.f_globals.get("__name__", ""))
    ours = module.startswith("bt_manip.") or module.partition(".")[0] == "importlib"
    return not ours and not frame.f_code.co_filename.startswith("<frozen")
