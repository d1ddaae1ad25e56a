"""The observers of a run."""

from pathlib import Path
from typing import TYPE_CHECKING

from bt_manip.cli.plugin_options import print_warning
from bt_manip.cli.record_option import record_target
from bt_manip.cli.run_options import RunOptions
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import parameters_of, read_words
from bt_manip.plugins import Plugins, guarded, plugin_observers
from bt_manip.record import SnapshotWriter, check_writable
from bt_manip.runner import Reloader, Run, RunObserver, Stopwatch, known_behaviours, recorder_name

if TYPE_CHECKING:
    from rich.console import Console

    from bt_manip.cli.session import Session


def observers_of(
    run: Run,
    options: RunOptions,
    session: "Session",
    recorder: RunObserver,
    window: RunObserver | None,
) -> list[RunObserver]:
    """Return the observers of a run, in the order of their calls; views are opened.

    Raises a `BtManipError` if there is no such observer, or it cannot write its file.
    """
    plugins = session.plugins
    # First: a trace in use by others ends the run before its report is begun.
    observers = [_recorder(plugins, f"trace={options.trace}")] if options.trace else []
    observers += [recorder]
    observers += [SnapshotWriter(*one, print_warning) for one in options.snapshots]
    if options.continued is not None:
        observers += [options.continued.interventions]
    observers += [_recorder(plugins, text) for text in options.records]
    observers += plugin_observers(plugins, print_warning)
    observers += _stopwatch(plugins)
    if options.watch:
        known = known_behaviours(plugins.parts)
        observers += [Reloader(run.request.tree, known, session.tell)]
    if not options.quiet:
        view = _terminal(session.console, options.cycles)
        observers += [guarded(view, "the view in the terminal", print_warning)]
    if window is not None:
        observers += [guarded(window, "the window", print_warning)]
    observers += session.open_views()
    if options.varied:
        observers += [_NeverPresent()]
    return observers


class _NeverPresent(RunObserver):
    """Warns after the run of varied quantities whose objects were in the cell in no cycle."""

    def run_started(self, run: Run) -> None:
        self._run = run
        self._absent: list[str] | None = None  # before the end of a cycle

    def cycle_ended(self, status: str, reason: str) -> None:
        known = self._absent
        self._absent = [name for name in self._run.absent if known is None or name in known]

    def run_ended(self) -> None:
        if self._absent:
            print_warning(f"{', '.join(self._absent)}: no such object was ever in the cell")


def _stopwatch(plugins: Plugins) -> list[RunObserver]:
    """Return a stopwatch of the plugins' controllers, if there are any."""
    controllers = plugins.parts.controllers
    origins = {name: plugins.origin(controllers.owner(name))[0] for name in controllers.names()}
    labels = {n: f"controller '{n}'{origin}" for n, origin in origins.items() if origin}
    return [Stopwatch(labels, print_warning)] if labels else []


def _terminal(console: "Console", cycles: int) -> RunObserver:
    if console.is_terminal and not console.is_dumb_terminal:
        from bt_manip.viewer import TerminalView

        return TerminalView(console, cycles=cycles)
    from bt_manip.viewer import PlainView

    return PlainView(console, cycles=cycles)


def _recorder(plugins: Plugins, text: str) -> RunObserver:
    recorders = plugins.parts.recorders
    name, file, words = record_target(text)
    try:
        name = name or recorder_name(Path(file).suffix, recorders)
    except BtManipError as error:
        raise BtManipError(f"--record: {error}; --record NAME=FILE names the recorder") from None
    make = recorders.maker(name, "run_started", expected="a RunObserver")
    path = Path(file) if file else None
    if path is not None:
        check_writable(path, f"--record {name}")
    options = parameters_of(make, keyword_only=True)
    recorder = make(path, **read_words(words.split(), options, f"recorder '{name}'"))
    label, hint = plugins.origin(recorders.owner(name))
    return guarded(recorder, f"recorder '{name}'{label}", print_warning, hint)
