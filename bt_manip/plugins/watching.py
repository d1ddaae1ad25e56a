"""Observers of plugins and views, isolated so that their exceptions do not end the run."""

import traceback
from collections.abc import Callable, Collection
from functools import partialmethod
from typing import Any, TypeVar

from bt_manip.exceptions import BtManipError
from bt_manip.plugins.plugin import Plugin, Plugins
from bt_manip.record import RecordingError
from bt_manip.runner import Run, RunObserver

T = TypeVar("T")
Warn = Callable[[str], None]


def plugin_observers(plugins: Plugins, warn: Warn) -> list[RunObserver]:
    """Return an observer for each plugin with observing hooks; `warn` reports exceptions."""
    return [
        guarded(HookObserver(plugin), plugin.label, warn, plugin.way_out)
        for plugin in plugins.plugins
        if plugin.observers
    ]


class HookObserver(RunObserver):
    """Calls the observing hooks of one plugin."""

    def __init__(self, plugin: Plugin) -> None:
        self._hooks = plugin.observers
        self._offers: dict[str, Any] = {}

    def run_started(self, run: Run) -> None:
        """Store the arguments of the hooks."""
        self._offers = {"station": run.station, "tree": run.tree}

    def after_compile(self) -> None:
        """Call ``after_compile``."""
        self._call("after_compile")

    def cycle_started(self, cycle: int) -> None:
        """Call ``cycle_started``."""
        self._offers["cycle"] = cycle
        self._call("cycle_started")

    def before_tick(self) -> None:
        """Call ``before_tick``."""
        self._call("before_tick")

    def after_tick(self) -> None:
        """Call ``after_tick``."""
        self._call("after_tick")

    def cycle_ended(self, status: str, reason: str) -> None:
        """Call ``cycle_ended``."""
        self._offers.update(status=status, reason=reason)
        self._call("cycle_ended")

    def _call(self, name: str) -> None:
        for hook in self._hooks:
            if hook.name == name:
                hook.function(**{key: self._offers[key] for key in hook.arguments})


def guarded(observer: T, label: str, warn: Warn, hint: str = "", base: Any = RunObserver) -> T:
    """Wrap an observer so that after an exception it is not called again and the run continues.

    Bad input that its `check` finds, and a `bt_manip.record.RecordingError`, end the run: what was
    asked for cannot be done.

    Args:
        observer: The observer.
        label: Its name, for the message.
        warn: Called with one line about the exception.
        hint: End of this line.
        base: Class of the observer's interface.
    """
    forwarded = {
        name: partialmethod(_Guard._try, name)
        for name, idle in vars(base).items()
        if callable(idle) and getattr(type(observer), name) is not idle and name not in vars(_Guard)
    }
    # The runner skips methods that an observer does not have.
    guard: Any = type("Guard", (_Guard, base), forwarded)
    return guard(observer, label, warn, hint)


class _Guard:
    """Calls an observer until it raises an exception."""

    def __init__(self, observer: Any, label: str, warn: Warn, hint: str) -> None:
        self._observer, self._label, self._warn, self._hint = observer, label, warn, hint
        self._works = True

    @property
    def kinds(self) -> Collection[str]:
        """Kinds of events requested by the observer."""
        return self._observer.kinds

    def run_ended(self) -> None:
        """Forward the call, also after an exception: resources must be released."""
        self._works, said = True, not self._works
        self._try("run_ended", quiet=said)

    def _try(self, name: str, *arguments: Any, quiet: bool = False) -> None:
        if not self._works:
            return
        try:
            getattr(self._observer, name)(*arguments)
        except (Exception, SystemExit) as error:
            is_bad_input = name == "check" and isinstance(error, BtManipError)
            if is_bad_input or isinstance(error, RecordingError):
                raise
            self._works = False
            if not quiet:
                what = f"{type(error).__name__}: {' '.join(str(error).split())}".rstrip(": ")
                last = traceback.extract_tb(error.__traceback__)[-1]
                self._warn(
                    f"{self._label} is not called again, the run continues: {what} at "
                    f"{last.filename}:{last.lineno}{self._hint}"
                )
