"""Observers of a run from plugins and options."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bt_manip.cli.plugin_options import print_warning
from bt_manip.cli.record_option import record_target
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import parameters_of, read_words
from bt_manip.plugins import BUILTIN, Plugin, Plugins, guarded, plugin_observers
from bt_manip.record import check_writable
from bt_manip.registry import Registry
from bt_manip.runner import RunObserver, Stopwatch, recorder_name


def extra_observers(plugins: Plugins, records: Iterable[str]) -> list[RunObserver]:
    """Return the requested recorders, the plugins' observers and the stopwatch of controllers.

    Args:
        plugins: All plugins.
        records: The values of ``--record``.

    Raises:
        BtManipError: If there is no such recorder, or it cannot write its file.
    """
    observers = [_recorder(plugins, text) for text in records]
    observers += plugin_observers(plugins, print_warning)
    controllers = plugins.parts.controllers
    owners = {name: _owner(plugins, controllers.owner(name)) for name in controllers.names()}
    labels = {n: f"controller '{n}' of {owner.label}" for n, owner in owners.items() if owner}
    if labels:
        observers.append(Stopwatch(labels, print_warning))
    return observers


def _recorder(plugins: Plugins, text: str) -> RunObserver:
    recorders = plugins.parts.recorders
    name, file, words = record_target(text)
    name = name or _recorder_of(Path(file).suffix, recorders)
    path = Path(file) if file else None
    owner = _owner(plugins, recorders.owner(name))
    if path is not None:
        check_writable(path, f"--record {name}")
    options = parameters_of(recorders.get(name), keyword_only=True)
    values = read_words(words.split(), options, f"recorder '{name}'")
    recorder = recorders.create(name, path, **values)
    if not isinstance(recorder, RunObserver):
        raise BtManipError(
            f"recorder '{name}' of plugin '{recorders.owner(name)}' makes no RunObserver, "
            f"got {recorder!r}"
        )
    if owner is None:
        return recorder
    return guarded(recorder, owner.label, print_warning, owner.way_out)


def _recorder_of(suffix: str, recorders: Registry[Any]) -> str:
    """Return the name of the recorder whose files have a suffix.

    Raises:
        BtManipError: If there is none.
    """
    try:
        return recorder_name(suffix, recorders)
    except BtManipError as error:
        raise BtManipError(f"--record: {error}; --record NAME=FILE names the recorder") from None


def _owner(plugins: Plugins, name: str) -> Plugin | None:
    """Return the plugin of a name; None for the built-in one."""
    return None if name == BUILTIN else plugins.find(name)
