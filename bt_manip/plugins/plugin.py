"""What is known of plugins once they are loaded."""

import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from bt_manip.plugins.entry_points import block_names
from bt_manip.registry import Parts

BUILTIN = "builtin"
"""Name of the plugin that brings the built-in parts."""


class PluginWarning(UserWarning):
    """A plugin is broken and was left out."""


@dataclass(frozen=True)
class ObserverHook:
    """A plugin's function that is called during a run.

    Attributes:
        name: The hook: ``"before_tick"``, ...
        function: The plugin's function.
        arguments: Names of the arguments that it takes, of those that the hook offers.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[str, ...]


@dataclass(frozen=True)
class Plugin:
    """One plugin, whether it works or not.

    Attributes:
        name: Its name, that of its entry point.
        version: Version of the package that it is from; empty when unknown.
        package: Name of that package; empty when it is from none.
        source: The file that it was loaded from, or the value of its entry point.
        provides: Names of the parts that it brings, by kind.
        observers: Its functions that watch runs.
        problem: What is wrong with it; empty when it works.
        blocked: Whether the user does not want it; it was not loaded then.
        module: Name of the module that it is, for telling whose code raised.
    """

    name: str
    version: str = ""
    source: str = ""
    provides: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    observers: tuple[ObserverHook, ...] = ()
    problem: str = ""
    blocked: bool = False
    module: str = ""
    package: str = ""

    @property
    def status(self) -> Literal["ok", "broken", "blocked"]:
        """How it is with this plugin."""
        if self.blocked:
            return "blocked"
        return "broken" if self.problem else "ok"

    @property
    def names(self) -> set[str]:
        """The names that it can be blocked by."""
        return block_names(self.name, self.package)

    @property
    def label(self) -> str:
        """Name it with its version and its file, for messages."""
        version = f" {self.version}" if self.version else ""
        where = f" ({self.source})" if self.source else ""
        return f"plugin '{self.name}'{version}{where}"

    @property
    def warning(self) -> str:
        """Say in one line that it is left out, why, and how to be asked no more."""
        return f"{self.label} is left out: {self.problem}{self.way_out}"

    @property
    def way_out(self) -> str:
        """Say how a user does without this plugin."""
        return f" (to do without it: --block {self.name})"


@dataclass(frozen=True)
class Plugins:
    """All plugins that were found, and the parts of those that work."""

    parts: Parts
    plugins: tuple[Plugin, ...]

    def find(self, name: str) -> Plugin | None:
        """Give the plugin of a name, one that works before one that does not."""
        named = sorted((p for p in self.plugins if p.name == name), key=lambda p: p.status != "ok")
        return named[0] if named else None

    def blame(self, error: BaseException) -> Plugin | None:
        """Name the plugin whose code an exception came out of.

        The innermost frame that belongs to a plugin's package decides; where there is none, the
        exception's ``culprit``, the name of a module, when it has one, or its ``plugin``. The
        built-in plugin is nobody to blame.
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
    """List an exception and what it was raised from."""
    chain: list[BaseException] = []
    cause: BaseException | None = error
    while cause is not None and cause not in chain:
        chain.append(cause)
        cause = cause.__cause__
    return chain


def _modules(chain: list[BaseException]) -> Iterator[str]:
    """Name the modules that an exception came through, from the innermost, then the culprits."""
    for link in reversed(chain):  # the first of a chain of exceptions is the innermost
        frames = [frame for frame, _ in traceback.walk_tb(link.__traceback__)]
        for frame in reversed(frames):
            yield str(frame.f_globals.get("__name__", ""))
    for link in chain:
        yield str(getattr(link, "culprit", ""))
