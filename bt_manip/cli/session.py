"""Runs of one command, one after the other; between them the cell lives."""

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from bt_manip.cli.exit_codes import INTERRUPTED, SUCCESS
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.plugin_options import load_chosen_plugins, print_warning
from bt_manip.cli.run_job import RunJob
from bt_manip.cli.run_options import RunOptions, make_request
from bt_manip.cli.streams import unfailing

if TYPE_CHECKING:
    from rich.console import Console

    from bt_manip.plugins import Plugins
    from bt_manip.runner import RunObserver, RunRequest, Station


def execute_run(
    options: RunOptions, interrupt: Interrupt, *, begin: bool = True,
    ended: Callable[[RunJob], None] = lambda job: None,
) -> int:  # fmt: skip
    """Run a tree, and the trees that a view asks for then; return the exit code.

    Args:
        options: The options.
        interrupt: The handler of Ctrl-C.
        begin: Whether the tree runs at once; else a view that controls runs starts it.
        ended: Called with that run when it has ended.

    Returns:
        The exit code of the first run; 130 where there is none.

    Raises:
        BtManipError: For bad input; nothing is simulated or written then.
    """
    session, code = Session(options, interrupt), INTERRUPTED
    with unfailing("stdout"), interrupt.held(), closing(session):
        with suppress(KeyboardInterrupt):
            if begin:
                code = session.begin()
                assert session.last is not None
                ended(session.last)
            else:
                session.show()
            is_over = begin and not interrupt.requested
            try:
                session.serve()
            finally:
                if is_over:
                    interrupt.exit_code = SUCCESS  # Ctrl-C has ended a view, not the run
    return code


class Session:
    """Runs of one command, one after the other; between them the cell lives.

    A run continues in the present station or begins in a new one, like the run of a command.

    Args:
        options: The options of the command.
        interrupt: The handler of Ctrl-C.

    Attributes:
        options: The options of the command.
        station: The station of the last run, or the one that was built last; None before.
        requested: Request of the last run, or of that station; None before.
        last: The last run; None before the first one.
        views: The opened views, by name.
    """

    def __init__(self, options: RunOptions, interrupt: Interrupt) -> None:
        self.options = options
        self.station: Station | None = None
        self.requested: RunRequest | None = None
        self.last: RunJob | None = None
        self._interrupt = interrupt
        self.views: dict[str, Any] = {}  # of RunViews
        self._built: tuple[Any, ...] = ()  # key of the station

    # For views

    @cached_property
    def plugins(self) -> "Plugins":
        """All plugins."""
        return load_chosen_plugins()

    @cached_property
    def stays(self) -> bool:
        """Whether a chosen view controls runs: it paces them, and starts others after the first."""
        return any(map(self._controls_runs, self.options.views))

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C was pressed, after which the session ends."""
        return self._interrupt.requested

    @cached_property
    def console(self) -> "Console":
        """The terminal."""
        from rich.console import Console

        return Console(quiet=self.options.quiet)

    def tell(self, line: str) -> None:
        """Print a line; also during a run, where a view may draw on the terminal."""
        from bt_manip.viewer import print_wrapped

        print_wrapped(self.console, line)
        sys.stdout.flush()  # a pipe has it at once too

    def request(self, **chosen: Any) -> "RunRequest":
        """Return the request of a further run.

        Args:
            **chosen: Options of the run that differ from those of the command.

        Raises:
            BtManipError: If there is no such tree, or an option is out of range.
        """
        return make_request(self._further(chosen), self.plugins.parts, by_view=self.stays)

    def has_station_of(self, request: "RunRequest") -> bool:
        """Return whether a run of the request can continue in the station as it is."""
        return request.station == self._built

    def build(self, request: "RunRequest") -> None:
        """Build the station of a request.

        Raises:
            BtManipError: If it cannot be built.
            KeyboardInterrupt: When interrupted.
        """
        from bt_manip.runner import prepare_station

        with self._interrupt.raised():
            self._let_go()
            self.station = prepare_station(request, self.plugins.parts)
        self.requested, self._built = request, request.station

    def run(self, *, in_place: bool, **chosen: Any) -> int:
        """Execute a further run; return its exit code.

        Args:
            in_place: Whether it continues in the station as it is, else in a new one.
            **chosen: Options of the run that differ from those of the command.

        Raises:
            BtManipError: For bad input.
        """
        return self._execute(self._further(chosen), self.station if in_place else None)

    # For runs

    def open_views(self) -> Iterator["RunObserver"]:
        """Open the chosen views, before the first run; yield them for a run, guarded.

        Exceptions in a view do not end the run.

        Raises:
            BtManipError: If a view cannot be opened.
        """
        from bt_manip.plugins import guarded

        parts = self.plugins.parts
        for name, given in self.options.views.items():
            if name not in self.views:
                make = parts.views.maker(name, "run_started", "close", expected="a RunView")
                self.views[name] = make(self, **given)
            label, hint = self.plugins.origin(parts.views.owner(name))
            yield guarded(self.views[name], f"view '{name}'{label}", print_warning, hint)

    # For the command

    def begin(self) -> int:
        """Execute the run of the command; return its exit code.

        Raises:
            BtManipError: For bad input.
        """
        return self._execute(self.options, None)

    def show(self) -> None:
        """Build the station of the command, and open the views.

        Raises:
            BtManipError: For bad input.
            KeyboardInterrupt: When interrupted.
        """
        with self._interrupt.raised():
            os.environ.setdefault("MUJOCO_GL", "disable")  # mujoco is imported without OpenGL
            if not self.options.tree:
                first = next(iter(self.plugins.parts.trees.in_order()), "")
                self.options = replace(self.options, tree=first)
            self.build(self.request())
            list(self.open_views())

    def serve(self) -> None:
        """Let the view that controls runs start others, until Ctrl-C.

        Raises:
            KeyboardInterrupt: When interrupted while a station is built, or for the second time.
        """
        for name, view in self.views.items():
            if self._controls_runs(name) and not self.interrupted:
                with self._interrupt.patient():
                    view.serve(self)

    def close(self) -> None:
        """Close the views that stay."""
        for view in self.views.values() if self.views and self.stays else ():
            view.close()

    # Internal

    def _controls_runs(self, name: str) -> bool:
        return getattr(self.plugins.parts.views.get(name), "controls_runs", False)

    def _let_go(self) -> None:
        """Let a real robot go, which a new station connects to again; no run continues then."""
        if self.station is not None and not self.station.hardware.simulated:
            self.station.hardware.close()
            self._built = ()

    def _execute(self, options: RunOptions, station: "Station | None") -> int:
        if station is None:
            self._let_go()
        job = RunJob(self, options, self._interrupt, station)
        self.last = job
        code = job.execute()
        if job.run is not None:
            self.station, self._built = job.run.station, job.run.request.station
        return code

    def _further(self, chosen: Mapping[str, Any]) -> RunOptions:
        """Return the options of a further run: settings and modifiers are for the same tree."""
        options = replace(
            self.options, window=False, report=None, trace=None, records=(), snapshots=(),
            resume=None, continued=None, episode=None,
        )  # fmt: skip
        if chosen.get("tree", options.tree) != options.tree:
            options = replace(options, settings={}, modifiers={}, varied=())
        return replace(options, **chosen)
