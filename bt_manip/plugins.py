"""Find plugins, check them one by one, and collect what they bring.

pluggy does not isolate: one plugin that does not import or raises stops all others, and a misspelt
hook passes unseen. So each plugin is loaded, checked and called here by itself, what it registers
is kept apart until all of its hooks have returned, and whatever goes wrong on the way is one
warning that names it. Nothing of a broken plugin stays.
"""

import importlib.metadata
import sys
import traceback
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any, Protocol

import pluggy

from bt_manip import hookspecs
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.plugin_stage import Stage
from bt_manip.registry import Parts

BUILTIN = "builtin"
"""Name of the plugin that brings the built-in parts."""


class PluginWarning(UserWarning):
    """A plugin is broken and was left out."""


class EntryPoint(Protocol):
    """What is read of an entry point; `importlib.metadata.EntryPoint` is one."""

    @property
    def name(self) -> str:
        """Name of the plugin."""

    @property
    def value(self) -> str:
        """Where it is, as ``package.module``."""

    @property
    def dist(self) -> Any:
        """The distribution that declares it, with `name` and `version`, or None."""

    def load(self) -> Any:
        """Import it."""


@dataclass(frozen=True)
class Plugin:
    """One plugin, whether it works or not.

    Attributes:
        name: Its name, that of its entry point.
        version: Version of the distribution that it is from; empty when unknown.
        source: The file that it was loaded from, or the value of its entry point.
        provides: Names of the parts that it brings, by kind.
        problem: What is wrong with it; empty when it works.
        module: Name of the module that it is, for telling whose code raised.
    """

    name: str
    version: str = ""
    source: str = ""
    provides: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    problem: str = ""
    module: str = ""

    @property
    def warning(self) -> str:
        """Say in one line that it is left out and why."""
        version = f" {self.version}" if self.version else ""
        where = f" ({self.source})" if self.source else ""
        return f"plugin '{self.name}'{version}{where} is left out: {self.problem}"


@dataclass(frozen=True)
class Plugins:
    """All plugins that were found, and the parts of those that work."""

    parts: Parts
    plugins: tuple[Plugin, ...]

    def blame(self, error: BaseException) -> Plugin | None:
        """Name the plugin whose code an exception came out of.

        The innermost frame that belongs to a plugin's package decides. The built-in plugin is
        nobody to blame.
        """
        owners = {p.module.partition(".")[0]: p for p in self.plugins if p.name != BUILTIN}
        frames = []
        cause: BaseException | None = error
        while cause is not None:  # the first of a chain of exceptions is the innermost
            frames += [frame for frame, _ in traceback.walk_tb(cause.__traceback__)]
            cause = cause.__cause__
        for frame in reversed(frames):
            package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
            if package in owners:
                return owners[package]
        return None


def load_plugins(
    *,
    entry_points: Iterable[EntryPoint] | None = None,
    builtin: object | None = None,
    warn: Callable[[str], None] | None = None,
) -> Plugins:
    """Load the built-in plugin and all that are installed.

    Args:
        entry_points: The plugins to load beside the built-in one; those installed in the group
            ``bt_manip`` when None.
        builtin: What takes the place of the built-in plugin, for tests.
        warn: What is called with the one line about each broken plugin; `warnings.warn` with
            a `PluginWarning` when None.

    Returns:
        The parts of all plugins that work, and every plugin with what it brings or its problem.
    """
    if warn is None:
        warn = _warn
    if builtin is None:
        from bt_manip import builtin as built_in_plugin

        builtin = built_in_plugin
    if entry_points is None:
        entry_points = importlib.metadata.entry_points(group=hookspecs.GROUP)
    parts = Parts()
    plugins = [_builtin(builtin, parts)]
    for point in sorted(entry_points, key=lambda p: (p.name, p.value)):
        plugin = _load(point, parts, [p.name for p in plugins])
        plugins.append(plugin)
        if plugin.problem:
            warn(plugin.warning)
    broken = [f"'{p.name}'" for p in plugins if p.problem]
    if broken:
        note = f" (left out because broken: plugin {', '.join(broken)})"
        for registry in parts.by_kind().values():
            registry.note = note
    return Plugins(parts, tuple(plugins))


def _warn(message: str) -> None:
    warnings.warn(message, PluginWarning, stacklevel=3)


def _builtin(plugin: object, parts: Parts) -> Plugin:
    """Collect the built-in parts; a fault in them is a bug and is not caught."""
    version = importlib.metadata.version("bt-manip")
    provides = _collect(plugin, BUILTIN, parts)
    return Plugin(BUILTIN, version, _file_of(plugin), provides, module=_module_of(plugin))


def _load(point: EntryPoint, parts: Parts, taken: list[str]) -> Plugin:
    version = str(point.dist.version) if point.dist is not None else ""
    source = point.value
    module = point.value.partition(":")[0]
    try:
        if point.name in taken:
            raise BtManipError("another plugin has the same name")
        plugin = point.load()
        source = _file_of(plugin) or source
        provides = _collect(plugin, point.name, parts)
    except (Exception, SystemExit) as error:
        return Plugin(point.name, version, source, problem=_describe(error), module=module)
    return Plugin(point.name, version, source, provides, module=module)


def _collect(plugin: object, owner: str, parts: Parts) -> dict[str, tuple[str, ...]]:
    """Call the hooks of one plugin and merge what it brings when all have returned."""
    stage = Stage(owner, parts)
    for name, function, arguments in _implementations(plugin):
        kind = name.removeprefix("register_")
        function(**{argument: stage.register(kind) for argument in arguments})
    return stage.merge()


def _implementations(plugin: object) -> list[tuple[str, Callable[..., Any], tuple[str, ...]]]:
    """Check the hooks of one plugin against their specifications.

    Returns:
        Of each hook its name, the plugin's function and the arguments that it takes.

    Raises:
        BtManipError: When a hook is misspelt or takes what is not offered, or there is none.
    """
    manager = pluggy.PluginManager(hookspecs.GROUP)
    manager.add_hookspecs(hookspecs)
    known = [name for name in vars(hookspecs) if name.startswith("register_")]
    for attribute in dir(plugin):
        options = manager.parse_hookimpl_opts(plugin, attribute)
        if options is None:
            continue
        name = options.get("specname") or attribute
        if name not in known:
            raise BtManipError(f"there is no hook '{name}'{did_you_mean(name, known)}")
        if options.get("wrapper") or options.get("hookwrapper"):
            raise BtManipError(f"'{name}' wraps other plugins' hooks; hooks only register")
    manager.register(plugin)
    found = [
        (name, impl.function, impl.argnames)
        for name in known
        for impl in getattr(manager.hook, name).get_hookimpls()
    ]
    if not found:
        raise BtManipError("it implements no hook; mark its functions with bt_manip.hookimpl")
    return found


def _file_of(plugin: object) -> str:
    """Give the file that a plugin came from, if it came from one."""
    if not isinstance(plugin, ModuleType):
        plugin = sys.modules.get(_module_of(plugin))
    return str(getattr(plugin, "__file__", None) or "")


def _module_of(plugin: object) -> str:
    if isinstance(plugin, ModuleType):
        return plugin.__name__
    return str(getattr(plugin, "__module__", ""))


def _describe(error: BaseException) -> str:
    """Say in one line what went wrong and, unless bt-manip found it, where."""
    text = " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, BtManipError):
        return text
    if isinstance(error, pluggy.PluginValidationError):
        return text.replace("\n", " ")
    frames = traceback.extract_tb(error.__traceback__)
    where = f" at {frames[-1].filename}:{frames[-1].lineno}" if frames else ""
    if isinstance(error, SyntaxError):
        where = f" at {error.filename}:{error.lineno}"
    return f"{type(error).__name__}: {text}{where}"
