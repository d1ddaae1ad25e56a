"""One run of the command line, from its options to its report."""

import contextlib
import gc
import io
import os
import traceback
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from bt_manip.cli.exit_codes import FAILED, FAULT, INTERRUPTED, SUCCESS
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.plugin_options import print_warning
from bt_manip.cli.record_option import is_rendered
from bt_manip.cli.run_options import RunOptions, make_request
from bt_manip.exceptions import ANY_BUT_INTERRUPT, BtManipError, NodeError, reason_of
from bt_manip.files import noting

if TYPE_CHECKING:
    from bt_manip.cli.session import Session
    from bt_manip.plugins import Plugins
    from bt_manip.record import Recorder, ReportFile, RunReport
    from bt_manip.runner import Run, RunObserver, Station
    from bt_manip.viewer import Window


class RunJob:
    """One run from its options to its report.

    Attributes:
        run: The run, once it is prepared.
        report: Its report, once it has ended.
        error: The internal fault that ended it; empty without one.
    """

    def __init__(
        self,
        session: "Session",
        options: RunOptions,
        interrupt: Interrupt,
        station: "Station | None" = None,
    ) -> None:
        self.run: Run | None = None
        self.report: RunReport | None = None
        self.error = ""
        self.options, self._session = options, session
        self._interrupt, self._station = interrupt, station
        self._plugins: Plugins | None = None
        self._recorder: Recorder | None = None
        self._report_file: ReportFile | None = None
        self._window: Window | None = None

    def execute(self) -> int:
        """Prepare and execute the run, write and print its results; return the exit code.

        Bad input raises a `BtManipError`; nothing is simulated or written then.
        """
        interrupt, started = self._interrupt, False
        with interrupt.held():
            try:
                with interrupt.raised(), _garbage_collection_off():
                    self.run, observers = self._prepare(self.options)
                started = True
                with interrupt.patient():
                    self.run.execute(observers, stop=lambda: interrupt.requested)
                code = INTERRUPTED if self.run.stop() else SUCCESS
            except KeyboardInterrupt:
                code = INTERRUPTED
            except ANY_BUT_INTERRUPT as error:
                from bt_manip.record import FileInUseError

                # An import can turn the interrupt into another exception.
                if interrupt.requested and not started:
                    return self._finish(INTERRUPTED)
                if isinstance(error, FileInUseError if started else BtManipError | PermissionError):
                    raise  # nothing has been simulated
                code = self._fault(error)
            return self._finish(INTERRUPTED if interrupt.requested else code)

    def lines(self, width: int) -> str:
        """Return the table of cycles and the lines after it, each of at most this width."""
        from rich.console import Console

        from bt_manip.cli.cycle_table import print_cycles

        assert self.report is not None
        text = io.StringIO()
        print_cycles(Console(file=text, width=width), self.report)
        return text.getvalue()

    def next_step(self, *, is_terminal: bool = False) -> str:
        """Return a line that says what to do after the run, or an empty text.

        Args:
            is_terminal: Whether the line is printed to a terminal, where it may be an idea only.
        """
        from bt_manip.cli.cycle_table import next_step

        assert self.report is not None
        return next_step(self.options, self.report, is_terminal=is_terminal)

    def _prepare(self, options: RunOptions) -> tuple["Run", list["RunObserver"]]:
        """Return the run and its observers; all bad input is found here."""
        session = self._session
        options = replace(options, window=self._can_open_window(options))
        self._plugins = session.plugins
        resumed = None
        if options.resume is not None:
            from bt_manip.record import read_snapshot

            resumed = read_snapshot(options.resume)
        parts, by_view = self._plugins.parts, session.stays
        read: dict[str, str] = {}
        with noting(read):
            request = session.requested = make_request(options, parts, resumed, by_view=by_view)
        # Slow imports come last: the errors above are reported at once.
        from bt_manip.cli.run_observers import observers_of
        from bt_manip.record import Recorder, restore_snapshot
        from bt_manip.runner import prepare

        run = prepare(request, parts, print_warning, self._station)
        if speeds := run.station.hardware.speeds:
            session.tell(speeds)
        run.identity["foreign"] = options.foreign.fields()
        run.files.update(read)
        if options.episode is not None:
            run.begin_episode(options.episode)
            run.identity["episode"] = options.episode
        self._recorder = Recorder(request.tree.name, request.seed, file=self._open_report())
        if resumed is not None:
            restore_snapshot(options.resume, resumed, run, self._recorder)
        if options.continued is not None:
            for warning in options.continued.differences(run):
                print_warning(warning)
            state = options.continued.simulate(run)
            restore_snapshot(options.continued.recording.path, state, run, self._recorder)
        if options.window:
            from bt_manip.viewer import Window

            self._window = Window()
        observers = observers_of(run, options, session, self._recorder, self._window)
        for observer in observers:
            observer.check(run)
        return run, observers

    def _fault(self, error: BaseException) -> int:
        """Print an exception with the plugin that it came from; return the exit code.

        What a node refuses, such as an entry that was never written, is a mistake in the tree, and
        no internal fault.
        """
        owner = self._plugins.blame(error) if self._plugins else None
        by = f"plugin '{owner.name}' {owner.version}".rstrip() + ": " if owner else ""
        text = str(error)
        if isinstance(error, NodeError) and isinstance(error.__cause__, BtManipError):
            place = self.run.tree.place_of(error.path) if self.run is not None else ""
            self.error = f"{place}: {by}{text}" if place else f"{by}{text}"
            click.echo(f"Error: {self.error}", err=True)
            return FAILED
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
        status = {FAULT: "ERROR", FAILED: "ERROR", SUCCESS: None}.get(code, "INTERRUPTED")
        self.report = report = self._report(status)
        if code == SUCCESS and report.status != "SUCCESS":
            code = FAILED
        if (file := self._open_report()) is not None:
            try:
                file.close(report)
            except BtManipError as error:  # a full disk, a deleted folder
                click.echo(f"Error: {error}", err=True)
                code = FAULT
        if report.ended_early:
            print_warning(f"the run ended early: {report.ended_early}")
        elif self.options.quiet and code == FAILED and not self.error:
            failed = (n for n, one in enumerate(report.cycles) if one.status == "FAILURE")
            number = next(failed, len(report.cycles) - 1)
            click.echo(f"cycle {number + 1} failed: {report.cycles[number].reason}", err=True)
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
            self._session.tell("The window stays open; close it or press Ctrl-C to leave.")
            self._window.wait_until_closed(lambda: self._interrupt.requested)
            self._interrupt.exit_code = SUCCESS  # the run itself was over
        self._window.close()

    def _report(self, status: str | None) -> "RunReport":
        if self._recorder is not None:
            return self._recorder.report(status, self.error)
        from bt_manip.record import RunReport, versions

        tree, seed = self.options.tree, self.options.seed or 0
        return RunReport(tree, seed, status or "INTERRUPTED", versions=versions(), error=self.error)

    def _print_cycles(self, report: "RunReport") -> None:
        if self._recorder is None or self.options.quiet:
            return
        from bt_manip.cli.cycle_table import print_cycles

        console = self._session.console
        print_cycles(console, report)
        if step := self.next_step(is_terminal=console.is_terminal):
            self._session.tell(step)

    @staticmethod
    def _can_open_window(options: RunOptions) -> bool:
        """Whether there will be a window; without one, mujoco is imported without OpenGL."""
        from bt_manip.viewer import NoDisplayError, require_display, use_offscreen_opengl

        if options.window:
            try:
                require_display()
                return True
            except NoDisplayError as error:
                print_warning(f"--window: {error}; the run has no window")
        if any(map(is_rendered, options.records)):
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
