"""One run of the command line, from its options to its report."""

import contextlib
import gc
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import click

from bt_manip.cli.exit_codes import FAILED, FAULT, INTERRUPTED, SUCCESS
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.plugin_options import load_chosen_plugins, print_warning
from bt_manip.cli.record_option import is_rendered
from bt_manip.cli.run_options import RunOptions, check_options, make_request
from bt_manip.exceptions import ANY_BUT_INTERRUPT, BtManipError, NodeError, reason_of
from bt_manip.registry import Parts

if TYPE_CHECKING:
    from rich.console import Console

    from bt_manip.plugins import Plugins
    from bt_manip.record import Continuation, Recorder, ReportFile, RunReport
    from bt_manip.runner import Run, RunObserver, RunRequest, RunView, Station
    from bt_manip.viewer import Page, Window


class RunJob:
    """One run from its options to its report.

    Args:
        interrupt: The handler of Ctrl-C.
        open_page: Returns the page on which the run is shown; None for none.
        station: As for `bt_manip.runner.prepare`.
        views: The views of plugins that stay after this run, by name; the run adds those that
            it opens. None: they end with this run.

    Attributes:
        options: The options.
        run: The run, once it is prepared.
        report: Its report, once it has ended.
        error: The internal fault that ended it; empty without one.
    """

    def __init__(
        self,
        options: RunOptions,
        interrupt: Interrupt,
        *,
        open_page: "Callable[[RunRequest, Plugins], Page] | None" = None,
        station: "Station | None" = None,
        views: "dict[str, RunView] | None" = None,
    ) -> None:
        self.options = options
        self._interrupt = interrupt
        self._open_page = open_page
        self._station = station
        self._views = views
        self.run: Run | None = None
        self.report: RunReport | None = None
        self.error = ""
        self._plugins: Plugins | None = None
        self._recorder: Recorder | None = None
        self._report_file: ReportFile | None = None
        self._window: Window | None = None
        self._page: Page | None = None
        self._started = False

    def execute(self) -> int:
        """Prepare and execute the run, write and print its results; return the exit code.

        Raises:
            BtManipError: For bad input; nothing is simulated or written then.
        """
        check_options(self.options)
        # From here on, finish() is called whatever happens.
        with self._interrupt.held():
            try:
                code = self._execute()
            except KeyboardInterrupt:
                code = INTERRUPTED
            except ANY_BUT_INTERRUPT as error:
                from bt_manip.record import FileInUseError

                # An import can turn the interrupt into another exception.
                if self._interrupt.requested:
                    code = INTERRUPTED
                elif isinstance(error, FileInUseError):  # nothing has been simulated
                    raise
                elif self._started or not isinstance(error, BtManipError):
                    code = self._fault(error)
                else:
                    raise
            return self._finish(INTERRUPTED if self._interrupt.requested else code)

    def _execute(self) -> int:
        """Prepare and execute the run; return its exit code if it was not interrupted."""
        with self._interrupt.raised(), _garbage_collection_off():
            self.run, observers = self._prepare()
        self._started = True
        with self._interrupt.patient():
            self.run.execute(observers, stop=lambda: self._interrupt.requested)
        return INTERRUPTED if self._page is not None and self._page.stopped else SUCCESS

    def _prepare(self) -> tuple["Run", list["RunObserver"]]:
        """Return the run and its observers; all bad input is found here."""
        options = replace(self.options, window=self._can_open_window())
        self._plugins = plugins = load_chosen_plugins()
        parts = plugins.parts
        resumed = None
        if options.resume is not None:
            from bt_manip.record import read_snapshot

            resumed = read_snapshot(options.resume)
        request = make_request(options, parts, resumed)
        # Slow imports come last: the errors above are reported at once.
        from bt_manip.cli.run_observers import extra_observers, plugin_views
        from bt_manip.plugins import guarded
        from bt_manip.record import Recorder, Trace
        from bt_manip.runner import prepare

        prepared = prepare(request, parts, print_warning, self._station)
        if speeds := prepared.station.hardware.speeds:
            self._tell(speeds)
        foreign = options.foreign.fields()
        prepared.identity.update(plugins=plugins.versions, foreign=foreign)
        if options.episode is not None:
            prepared.begin_episode(options.episode)
        self._recorder = Recorder(request.tree.name, request.seed, file=self._open_report())
        # First: a trace in use by others ends the run before its report is begun.
        observers: list[RunObserver] = [Trace(options.trace)] if options.trace else []
        observers.append(self._recorder)
        if options.snapshots or resumed is not None:
            from bt_manip.record import SnapshotWriter, restore_snapshot

            if resumed is not None:
                restore_snapshot(options.resume, resumed, prepared, self._recorder)
            observers += [SnapshotWriter(*one, print_warning) for one in options.snapshots]
        if options.continued is not None:
            observers += self._continue(options.continued, prepared, self._recorder)
        observers += extra_observers(plugins, options.records)
        if options.watch:
            from bt_manip.runner import Reloader, known_behaviours

            observers.append(Reloader(request.tree, known_behaviours(parts), self._tell))
        if not options.quiet:
            view = _terminal(self._console, options.cycles)
            observers.append(guarded(view, "the view in the terminal", print_warning))
        if options.window:
            from bt_manip.viewer import Window

            self._window = Window()
            observers.append(guarded(self._window, "the window", print_warning))
        observers += plugin_views(plugins, options.views, self._tell, self._views)
        if self._open_page is not None:
            self._page = self._open_page(request, plugins)
            observers.append(guarded(self._page, "the page", print_warning))
        if options.faults:
            observers.append(self._fault_injector(prepared, parts))
        for observer in observers:
            observer.check(prepared)
        return prepared, observers

    @cached_property
    def _console(self) -> "Console":
        from rich.console import Console

        return Console(quiet=self.options.quiet)

    def _fault_injector(self, run: "Run", parts: Parts) -> "RunObserver":
        """Return an observer that injects the requested faults.

        Raises:
            BtManipError: If a fault is described wrongly.
        """
        from bt_manip.faults import FaultInjector, parse_fault

        planned = [parse_fault(text, parts.faults) for text in run.request.faults]
        for one in planned:
            one.nodes(run.tree)
        return FaultInjector(planned, parts.faults, run.request.seed, warn=print_warning)

    @staticmethod
    def _continue(
        continued: "Continuation", run: "Run", recorder: "Recorder"
    ) -> list["RunObserver"]:
        """Restore the moment of a recorded run; return the repetition of its interventions.

        Raises:
            BtManipError: If the run is not the recorded one.
        """
        from bt_manip.record import RecordedInterventions, restore_snapshot

        for warning in continued.differences(run):
            print_warning(warning)
        path = continued.recording.path
        restore_snapshot(path, continued.simulate(run), run, recorder)
        return [RecordedInterventions(continued.recording)]

    def _tell(self, message: str) -> None:
        """Print a line; also during the run, where a view may draw on the terminal."""
        from bt_manip.viewer import print_wrapped

        print_wrapped(self._console, message)
        sys.stdout.flush()  # a pipe has it at once too

    def _fault(self, error: BaseException) -> int:
        """Print an exception with the plugin that it came from; return the exit code."""
        owner = self._plugins.blame(error) if self._plugins else None
        by = f"plugin '{owner.name}' {owner.version}".rstrip() + ": " if owner else ""
        text = str(error)
        if not isinstance(error, BtManipError):
            cause = error.__cause__ or error  # of a NodeError: the exception of the node itself
            if not isinstance(cause, BtManipError):  # else the message says it all
                traceback.print_exception(cause)
            if not isinstance(error, NodeError) and not hasattr(error, "culprit"):
                text = reason_of(error)
        self.error = f"{by}{text}"
        from bt_manip.record import RecordingError

        what = "the run ended with an internal fault: "
        click.echo(
            f"Error: {'' if isinstance(error, RecordingError) else what}{self.error}", err=True
        )
        return FAULT

    def _finish(self, code: int) -> int:
        """Write and print the results, then wait for the window; return the exit code."""
        status = {FAULT: "ERROR", SUCCESS: None}.get(code, "INTERRUPTED")
        self.report = report = self._report(status)
        if code == SUCCESS and report.status != "SUCCESS":
            code = FAILED
        if (file := self._open_report()) is not None:
            try:
                file.close(report)
            except BtManipError as error:  # a full disk, a deleted folder
                click.echo(f"Error: {error}", err=True)
                code = FAULT
        for show in (lambda: self._print_cycles(report), self._keep_window):
            try:
                show()
            except Exception as error:
                print_warning(f"the results are not shown: {type(error).__name__}: {error}")
        return code

    def _open_report(self) -> "ReportFile | None":
        if self._report_file is None and self.options.report is not None:
            from bt_manip.record import open_report_file

            self._report_file = open_report_file(self.options.report, print_warning)
        return self._report_file

    def _keep_window(self) -> None:
        """Keep the window open until it is closed, or Ctrl-C."""
        if self._window is None:
            return
        if self._window.is_open and not self._interrupt.requested:
            self._tell("The window stays open; close it or press Ctrl-C to leave.")
            self._window.wait_until_closed(lambda: self._interrupt.requested)
            self._interrupt.exit_code = SUCCESS  # the run itself was over
        self._window.close()

    def _report(self, status: str | None) -> "RunReport":
        if self._recorder is not None:
            return self._recorder.report(status, self.error)
        import hashlib

        from bt_manip.record import RunReport, versions

        options = self.options
        return RunReport(
            tree=options.tree,
            seed=options.seed or 0,
            status=status or "INTERRUPTED",
            state_digest=hashlib.sha256().hexdigest(),
            versions=versions(),
            error=self.error,
            robot=options.robot,
            scene=options.scene or "",
            controller=options.controller or "",
            planner=options.planner,
            settings=dict(options.settings),
            faults=options.faults,
            tick_s=options.tick_ms / 1e3,
        )

    def _print_cycles(self, report: "RunReport") -> None:
        if self._recorder is None or self.options.quiet:
            return
        from bt_manip.cli.cycle_table import next_step, print_cycles

        print_cycles(self._console, report)
        step = next_step(self.options, report, is_terminal=self._console.is_terminal)
        if step:
            self._tell(step)

    def _can_open_window(self) -> bool:
        """Whether there will be a window; without one, mujoco is imported without OpenGL."""
        from bt_manip.viewer import NoDisplayError, require_display, use_offscreen_opengl

        if self.options.window:
            try:
                require_display()
                return True
            except NoDisplayError as error:
                print_warning(f"--window: {error}; the run has no window")
        if any(map(is_rendered, self.options.records)):
            use_offscreen_opengl()
        os.environ.setdefault("MUJOCO_GL", "disable")
        return False


@contextlib.contextmanager
def _garbage_collection_off() -> Iterator[None]:
    """Switch the garbage collector off while a run is prepared, and freeze the objects that exist.

    Most of them stay until the run ends: each collection, also during the run, would traverse them
    and free nothing.
    """
    gc.unfreeze()  # objects of an earlier run
    gc.disable()
    try:
        yield
        gc.freeze()
    finally:
        gc.enable()


def _terminal(console: "Console", cycles: int) -> "RunObserver":
    if console.is_terminal and not console.is_dumb_terminal:
        from bt_manip.viewer import TerminalView

        return TerminalView(console, cycles=cycles)
    from bt_manip.viewer import PlainView

    return PlainView(console, cycles=cycles)
