"""Loaded, broken and blocked plugins."""

import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.plugins.entry_points import block_names
from bt_manip.registry import Parts

BUILTIN = "builtin"
"""Name of the plugin with the built-in parts."""


class PluginWarning(UserWarning):
    """A plugin is broken and was left out."""


class Implementation(NamedTuple):
    """Function of a plugin that implements a hook."""

    name: str  # of the hook
    function: Callable[..., Any]
    arguments: tuple[str, ...]  # arguments of the hook that it takes


@dataclass(frozen=True)
class Plugin:
    """A plugin, working or not.

    Attributes:
        name: Name of its entry point.
        version: Version of its package; empty if unknown.
        package: Name of its package; empty without one.
        source: Its file, or the value of its entry point.
        provides: Names of its parts, by kind.
        observers: Its functions that observe runs.
        problem: Description of its error; empty if it works.
        blocked: Whether it is blocked and therefore not loaded.
        module: Name of its module, to attribute exceptions.
    """

    name: str
    version: str = ""
    source: str = ""
    provides: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    observers: tuple[Implementation, ...] = ()
    problem: str = ""
    blocked: bool = False
    module: str = ""
    package: str = ""

    @property
    def status(self) -> Literal["ok", "broken", "blocked"]:
        """Status of the plugin."""
        if self.blocked:
            return "blocked"
        return "broken" if self.problem else "ok"

    @property
    def names(self) -> set[str]:
        """Names that block it."""
        return block_names(self.name, self.package)

    @property
    def label(self) -> str:
        """Name, version and file, for messages."""
        version = f" {self.version}" if self.version else ""
        where = f" ({self.source})" if self.source else ""
        return f"plugin '{self.name}'{version}{where}"

    @property
    def warning(self) -> str:
        """Message that it is left out, with the reason and the option that blocks it."""
        return f"{self.label} is left out: {self.problem}{self.way_out}"

    @property
    def way_out(self) -> str:
        """Hint at the option that blocks it."""
        return f" (to block it: --block {self.name})"


@dataclass(frozen=True)
class Plugins:
    """All plugins, and the parts of the working ones."""

    parts: Parts
    plugins: tuple[Plugin, ...]

    def find(self, name: str) -> Plugin | None:
        """Return a plugin by name, preferably a working one, or None."""
        named = sorted((p for p in self.plugins if p.name == name), key=lambda p: p.status != "ok")
        return named[0] if named else None

    def working(self, name: str) -> Plugin:
        """Return a working plugin.

        Raises:
            BtManipError: When it is unknown or broken.
        """
        plugin = self.find(name)
        if plugin is None:
            known = [each.name for each in self.plugins]
            raise BtManipError(f"no plugin '{name}'{did_you_mean(name, known)}")
        if plugin.problem:
            raise BtManipError(plugin.warning)
        return plugin

    def origin(self, name: str) -> tuple[str, str]:
        """Return the ends of a part's label and of messages about it, by the name of its plugin.

        They are empty for the built-in plugin.
        """
        owner = None if name == BUILTIN else self.find(name)
        return (f" of {owner.label}", owner.way_out) if owner else ("", "")

    def blame(self, error: BaseException) -> Plugin | None:
        """Return the plugin whose code raised an exception, or None for bt-manip's own code.

        It is the plugin of the innermost frame in a plugin's package, or else of the exception's
        attribute ``culprit`` (name of a module) or ``plugin``.
        """
        owners = {p.module.partition(".")[0]: p for p in self.plugins if p.name != BUILTIN}
        chain = _chain(error)
        for module in _modules(chain):
            owner = owners.get(module.partition(".")[0])
            if owner is not None:
                return owner
        named = [self.find(getattr(link, "plugin", "")) for link in chain]
        return next((p for p in named if p is not None and p.name != BUILTIN), None)


def _chain(error: BaseException) -> list[BaseException]:
    """Return an exception and its causes."""
    chain: list[BaseException] = []
    cause: BaseException | None = error
    while cause is not None and cause not in chain:
        chain.append(cause)
        cause = cause.__cause__
    return chain


def _modules(chain: list[BaseException]) -> Iterator[str]:
    """Yield the modules of an exception's frames, innermost first, then its culprits."""
    for link in reversed(chain):  # the innermost exception is the last one
        frames = [frame for frame, _ in traceback.walk_tb(link.__traceback__)]
        for frame in reversed(frames):
            yield str(frame.f_globals.get("__name__", ""))
    for link in chain:
        yield str(getattr(link, "culprit", ""))
