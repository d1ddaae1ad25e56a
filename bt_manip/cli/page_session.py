"""The page of the command line: runs that are chosen on it, and the cell between them."""

import contextlib
import io
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.exit_codes import INTERRUPTED, SUCCESS
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.plugin_options import load_chosen_plugins
from bt_manip.cli.run_job import RunJob
from bt_manip.cli.run_options import RunOptions, make_request
from bt_manip.exceptions import BtManipError, require_extra

if TYPE_CHECKING:
    from bt_manip.plugins import Plugins
    from bt_manip.runner import RunLoop, RunRequest, RunView, Station
    from bt_manip.viewer import Page
    from bt_manip.viewer.page import RunChoice

FIRST_LOOK = 10.0
"""Longest wait for a browser before the first run [s]."""

RESULT_WIDTH = 46
"""Characters of a line of the result on the page."""

SAVED = Path("configurations.toml")
"""File of the configurations that are saved on the page, unless an option names one."""


def execute_run(options: RunOptions, interrupt: Interrupt) -> int:
    """Run a tree, on a page if the options ask for one; return the exit code.

    Raises:
        BtManipError: For bad input; nothing is simulated or written then.
    """
    if options.view:
        return execute_on_page(options, interrupt, run=True)
    return RunJob(options, interrupt).execute()


def execute_on_page(options: RunOptions, interrupt: Interrupt, *, run: bool) -> int:
    """Serve a page until Ctrl-C.

    Args:
        options: The options of the first run, and of the runs that are chosen on the page: those
            of files are for the first run only, settings and faults only for its tree.
        interrupt: The handler of Ctrl-C.
        run: Whether the tree runs at once.

    Returns:
        The exit code of the first run; 130 where there is none.

    Raises:
        BtManipError: For bad input, before the page is served.
    """
    require_extra("view", "--view" if run else "view", "viser")
    with interrupt.held():
        session = PageSession(options, interrupt)
        code = INTERRUPTED
        with contextlib.closing(session), contextlib.suppress(KeyboardInterrupt):
            if run:
                code = session.run(options, None)
            else:
                session.prepare()
            if session.is_open and not interrupt.requested:
                try:
                    session.serve()
                finally:
                    if run:
                        interrupt.exit_code = SUCCESS  # the run itself was over
        return code


class PageSession:
    """Runs trees that are chosen on a page, one after the other; between them the cell lives.

    A run continues in the cell as it is. After a reset, and where scene, robot or seed are others,
    it begins as from the command line: with a new cell.

    Attributes:
        last: The last run.
    """

    def __init__(self, options: RunOptions, interrupt: Interrupt) -> None:
        self._options = options
        self._interrupt = interrupt
        self._page: Page | None = None
        self._plugins: Plugins | None = None
        self._station: Station | None = None
        self._built: tuple[Any, ...] = ()
        self._loop: RunLoop | None = None  # between runs; None while the cell stands still
        self._views: dict[str, RunView] = {}  # of plugins, of all runs
        self._request: RunRequest | None = None  # whose tree is shown before the first run
        self._is_new = False  # nothing has moved in the station since it was built
        self.last: RunJob | None = None

    def prepare(self) -> None:
        """Build the cell of the options, and open the page.

        Raises:
            BtManipError: For bad input.
            KeyboardInterrupt: When interrupted.
        """
        with self._interrupt.raised():
            os.environ.setdefault("MUJOCO_GL", "disable")  # mujoco is imported without OpenGL
            self._plugins = plugins = load_chosen_plugins()
            tree = self._options.tree or next(iter(plugins.parts.trees.in_order()), "")
            self._options = replace(self._options, tree=tree)
            request = make_request(self._options, plugins.parts)
            self._build(request)
            self._open_page(request, plugins)
            self._request = request

    def run(self, options: RunOptions, station: "Station | None") -> int:
        """Run a tree, in a station as it is or in a new one; return the exit code.

        Raises:
            BtManipError: For bad input.
        """
        job = self.last = RunJob(
            options, self._interrupt, open_page=self._await_page, station=station,
            views=self._views,
        )  # fmt: skip
        code = job.execute()
        if job.run is not None:
            self._station, self._built = job.run.station, job.run.request.station
            self._is_new = False
        if self._page is not None and job.report is not None:
            self._panel.show_result(job.report.status, self._result_of(job))
        return code

    def serve(self) -> None:
        """Serve the page until Ctrl-C.

        Raises:
            KeyboardInterrupt: When interrupted while a cell is built, or for the second time.
        """
        from bt_manip.runner import TICK, Pacing

        assert self._page is not None
        self._tell(f"The page stays up at {self._page.url}; press Ctrl-C to leave.")
        self._rest()
        if self._request is not None:
            self._show_tree(self._request)
        pacing, time = Pacing(1.0), 0.0  # also where the cell stands still
        with self._interrupt.patient():
            while not self._interrupt.requested:
                if (asked := self._panel.take()) is not None:
                    self._obey(*asked)
                    pacing.start(time)
                self._idle_tick()
                time += TICK
                pacing.wait(time)

    @property
    def is_open(self) -> bool:
        """Whether there is a page: a first run that ends before it begins opens none."""
        return self._page is not None

    def close(self) -> None:
        """Stop the servers."""
        if self._page is not None:
            self._page.close()
        for view in self._views.values():
            view.close()

    # Internal

    def _await_page(self, request: "RunRequest", plugins: "Plugins") -> "Page":
        """Return the page; before the first run, wait until a browser shows it, but not long."""
        if self._page is not None:
            return self._page
        page = self._open_page(request, plugins)
        if FIRST_LOOK:
            self._tell(f"The run begins when it is open, at the latest in {FIRST_LOOK:.0f} s.")
            page.wait_until_open(FIRST_LOOK, lambda: self._interrupt.requested)
        return page

    def _open_page(self, request: "RunRequest", plugins: "Plugins") -> "Page":
        from bt_manip.cli.run_observers import page_panels
        from bt_manip.registry import TreeDefaults
        from bt_manip.runner import SCENE
        from bt_manip.scenes import seed_of
        from bt_manip.viewer import Page
        from bt_manip.viewer.page import JogPanel, RunChoice, SessionPanel

        parts, self._plugins = plugins.parts, plugins
        first = RunChoice(
            self._options.tree, str(request.scene), str(request.robot), request.seed, request.cycles
        )
        known = {
            "tree": parts.trees.names(), "scene": parts.scenes.names(),
            "robot": parts.robots.names(),
        }  # fmt: skip
        names = {
            kind: tuple(dict.fromkeys([getattr(first, kind), *registered]))
            for kind, registered in known.items()
        }

        def scene_of(tree: str) -> str:
            wanted = parts.tree_defaults.get(tree, TreeDefaults()).scene
            return self._options.scene or wanted or SCENE

        def make_session(page: Any) -> SessionPanel:
            self._panel = SessionPanel(page, names, first, scene_of, lambda s: seed_of(s, parts))
            return self._panel

        def make_jog(page: Any) -> JogPanel:
            self._jog = JogPanel(page, self._save)
            return self._jog

        make_session.place = "left"  # type: ignore[attr-defined]
        panels = {"run": make_session, **page_panels(plugins), "jog": make_jog}
        self._page = Page(panels, speed=self._options.speed or None)
        self._tell(f"The page of the run: {self._page.url}")
        return self._page

    def _tell(self, message: str) -> None:
        if not self._options.quiet:
            click.echo(message)

    def _result_of(self, job: RunJob) -> str:
        """Return the lines that a run ends with in the terminal, and what can be done next."""
        from rich.console import Console

        from bt_manip.cli.cycle_table import next_step, print_cycles

        assert job.report is not None
        lines = io.StringIO()
        print_cycles(Console(file=lines, width=RESULT_WIDTH), job.report)
        again = (
            f"To keep it: bt-manip run {job.report.tree} --seed {job.report.seed} --record "
            "run.mcap; then bt-manip replay run.mcap, or bt-manip report run.mcap."
        )
        steps = next_step(job.options, job.report, on_page=True) or again
        steps += "\n\nRun starts it again; another seed places the objects elsewhere."
        return f"{lines.getvalue()}\n{steps}"

    def _show_tree(self, request: "RunRequest") -> None:
        """Show the tree of a request that does not run yet; a mistake is shown when it runs."""
        from bt_manip.runner import prepare

        assert self._plugins is not None and self._page is not None
        with contextlib.suppress(BtManipError):
            self._page.show_prepared(prepare(request, self._plugins.parts, station=self._station))

    def _obey(self, action: str, choice: "RunChoice") -> None:
        """Execute the request of the page; errors are shown there."""
        assert self._plugins is not None and self._page is not None
        options = self._options_of(choice)
        try:
            request = make_request(options, self._plugins.parts)
            same = request.station == self._built
            if action == "run":
                self._panel.tell("preparing the run")
                self._page.controls.stopped = False
                self.run(options, self._station if same and not self._is_new else None)
                self._rest()
            elif action == "reset" or not same:
                self._panel.tell("building the cell")
                with self._interrupt.raised():
                    self._build(request)
                self._rest()
            if action == "show":
                self._show_tree(request)
            self._panel.tell(self.last.error if action == "run" and self.last else "", error=True)
        except BtManipError as error:
            self._panel.tell(str(error), error=True)
        except (Exception, SystemExit) as error:  # of a plugin
            self._panel.tell(f"{type(error).__name__}: {error}", error=True)

    def _options_of(self, choice: "RunChoice") -> RunOptions:
        """Return the options of a run that was chosen on the page."""
        first, same = self._options, choice.tree == self._options.tree
        return replace(
            first, **choice._asdict(), window=False, report=None, trace=None, records=(),
            snapshots=(), resume=None, continued=None, episode=None,
            settings=first.settings if same else {},
            faults=first.faults if same else (), varied=first.varied if same else (),
        )  # fmt: skip

    def _build(self, request: "RunRequest") -> None:
        from bt_manip.runner import prepare_station

        assert self._plugins is not None
        self._station = prepare_station(request, self._plugins.parts)
        self._built, self._is_new = request.station, True

    def _rest(self) -> None:
        """Show the station in which no tree runs."""
        from bt_manip.runner import RunLoop

        assert self._page is not None
        if self._station is not None:
            self._page.begin_idle(self._station)
            if self._loop is not None:
                self._loop.close()
            self._loop = RunLoop(self._station.resting())
            self._loop.open()

    def _idle_tick(self) -> None:
        """Advance by a tick; the cell stands still after an exception, until the next request."""
        assert self._page is not None
        try:
            if self._loop is None:
                self._page.tick()
            else:
                self._loop.advance(self._page)
            self._is_new &= not self._jog.moved
        except (Exception, SystemExit) as error:
            self._loop = None
            self._panel.tell(f"the cell stands still: {error}; Reset builds it anew", error=True)

    def _save(self, name: str, q: Sequence[float]) -> str:
        """Save a configuration for the runs of this page and of others."""
        from bt_manip.robots import save_configuration

        path = self._options.configurations or SAVED
        save_configuration(path, name, q)
        self._options = replace(self._options, configurations=path)
        return (
            f"'{name}' is saved in {path.absolute()}; MoveToConfiguration finds it on this page, "
            f"and after bt-manip run TREE --configurations {path}"
        )
