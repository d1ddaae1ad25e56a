"""Observers of a run from plugins and options."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from bt_manip.cli.plugin_options import print_warning
from bt_manip.cli.record_option import record_target
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import parameters_of, read_words
from bt_manip.plugins import BUILTIN, Plugin, Plugins, guarded, plugin_observers
from bt_manip.record import check_writable
from bt_manip.registry import Registry
from bt_manip.runner import RunObserver, RunView, Stopwatch, recorder_name


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


def plugin_views(
    plugins: Plugins,
    chosen: Mapping[str, Mapping[str, Any]],
    tell: Callable[[str], None],
    staying: dict[str, RunView] | None,
) -> list[RunObserver]:
    """Return the chosen views of plugins; exceptions in a view do not end the run.

    Args:
        plugins: All plugins.
        chosen: The options of each view, by the name of the view.
        tell: Prints a line.
        staying: The views that stay after the run; new ones are added. None: views end with it.

    Raises:
        BtManipError: If a view cannot be opened.
    """
    views, made = plugins.parts.views, {} if staying is None else staying
    observers: list[RunObserver] = []
    for name, options in chosen.items():
        owner = _owner(plugins, views.owner(name))
        if name not in made:
            make = views.maker(name, "run_started", "close", expected="a RunView")
            made[name] = make(tell, staying is not None, **options)
        label, hint = f"view '{name}'", ""
        if owner is not None:
            label, hint = f"{label} of {owner.label}", owner.way_out
        observers.append(guarded(made[name], label, print_warning, hint))
    return observers


def page_panels(plugins: Plugins) -> dict[str, Callable[[Any], Any]]:
    """Return the makers of the panels of the page; exceptions in a panel do not end the run.

    Args:
        plugins: All plugins.
    """
    return {name: _panel_maker(plugins, name) for name in plugins.parts.panels.in_order()}


def _panel_maker(plugins: Plugins, name: str) -> Callable[[Any], Any]:
    from bt_manip.viewer import Panel

    panels = plugins.parts.panels
    owner = _owner(plugins, panels.owner(name))
    label, hint = f"panel '{name}'", ""
    if owner is not None:
        label, hint = f"{label} of {owner.label}", owner.way_out

    def make(page: Any) -> Any:
        try:
            panel = panels.maker(name, "start", "draw", expected="a Panel")(page)
        except (Exception, SystemExit) as error:
            print_warning(f"{label} is left out: {error}{hint}")
            return Panel(page)
        return guarded(panel, label, print_warning, hint, base=Panel)

    kind: Any = panels.get(name)
    make.place = getattr(kind, "place", Panel.place)  # type: ignore[attr-defined]
    make.needs_run = getattr(kind, "needs_run", Panel.needs_run)  # type: ignore[attr-defined]
    return make


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
