"""The view ``--view``: runs that are chosen on a page, and the cell between them."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from bt_manip.cli import RunOptions, Session, chosen, findings_of, given_options
from bt_manip.exceptions import BtManipError
from bt_manip.runner import (
    TICK,
    Pacing,
    Run,
    RunLoop,
    RunRequest,
    RunView,
    load_source,
    prepare,
)

from .page.breakpoints import nodes_of, problem_of
from .page.jog_panel import JogPanel
from .page.keep_panel import KeepPanel
from .page.page import Page
from .page.plugin_panels import page_panels
from .page.saved_configurations import save_configuration
from .page.server import PORT
from .page.session_panel import RunChoice, SessionPanel

FIRST_LOOK = 10.0
"""Longest wait for a browser before the first run [s]."""

RESULT_WIDTH = 46
"""Characters of a line of the result on the page."""

SAVED = Path("configurations.toml")
"""File of the configurations that are saved on the page, unless an option names one."""

NOT_REPEATED: Mapping[str, Any] = {
    "window": False, "quiet": False, "watch": False, "views": {}, "real_time": None,
    "report": None, "trace": None, "records": (), "snapshots": (),
}  # fmt: skip
"""Options that do not change a run, with their defaults."""


class PageView(Page, RunView):
    """The page of a session: shows its runs, starts further ones, and jogs the robot between them.

    A run continues in the cell as it is. After a reset, and where scene, robot or seed are others,
    it begins as from the command line: with a new cell.

    Args:
        session: The session.
        port: The first port to try; 0: chosen by the system.
        breakpoints: Names or paths of the nodes at whose start a run pauses.
    """

    def __init__(self, session: Session, port: int = PORT, breakpoints: Sequence[str] = ()) -> None:
        self._session, self._named = session, tuple(breakpoints)
        self._is_looked_at = False  # or was waited for
        self._in_place = False  # the last run began in the cell as it was
        self._is_new = False  # nothing has moved in the station since it was built
        self._loop: RunLoop | None = None  # between runs; None while the cell stands still

        def make_selection(page: Any) -> SessionPanel:
            self._selection = _selection(page, session)
            return self._selection

        make_selection.place = SessionPanel.place  # type: ignore[attr-defined]
        panels = {"run": make_selection, **page_panels(session.plugins)}
        super().__init__(panels, port=port, speed=session.options.speed or None)
        self._jog = self._add_panel("jog", lambda page: JogPanel(page, self._save))
        self._keep = self._add_panel("keep", KeepPanel)
        self.controls.breakpoints, self.watches = self._named, session.options.watch
        session.tell(f"The page of the run: {self.url}")

    def check(self, run: Run) -> None:
        """Wait before the first run until a browser shows the page, but not long.

        Raises:
            BtManipError: If the tree has no node of a breakpoint.
        """
        if self._is_looked_at:
            return
        if problem := problem_of(self._named, nodes_of(run.tree)):
            raise BtManipError(problem)
        self._session.tell(f"The run begins when it is open, at the latest in {FIRST_LOOK:.0f} s.")
        self.wait_until_open(FIRST_LOOK, lambda: self._session.interrupted)
        self._is_looked_at = True

    def serve(self, session: Session) -> None:
        """Serve the page until Ctrl-C.

        Raises:
            KeyboardInterrupt: When interrupted while a cell is built, or for the second time.
        """
        session.tell(f"The page stays up at {self.url}; press Ctrl-C to leave.")
        self._is_looked_at = True
        if session.last is None:
            self._is_new = True
            self._rest()
            self._show_tree_of(session.request())
        else:
            self._show_result()
            self._rest()
        pacing, time = Pacing(1.0), 0.0  # also where the cell stands still
        while not session.interrupted:
            if (asked := self._selection.take()) is not None:
                self._obey(*asked)
                pacing.start(time)
            self._idle_tick()
            time += TICK
            pacing.wait(time)
        self._leave_idle()

    # Internal

    def _obey(self, action: str, choice: RunChoice) -> None:
        """Execute a request of the page; errors are shown there."""
        session, chosen = self._session, choice._asdict()
        try:
            request = session.request(**chosen)
            same = session.has_station_of(request)
            error = ""
            if action == "run":
                self._selection.tell("preparing the run")
                error = self._execute(in_place=same and not self._is_new, **chosen)
            elif action == "reset" or not same:
                self._selection.tell("building the cell")
                session.build(request)
                self._is_new = True
                self._rest()
            if action == "show":
                self._show_tree_of(request)
            self._selection.tell(error, error=True)
        except BtManipError as error:
            self._selection.tell(str(error), error=True)
        except (Exception, SystemExit) as error:  # of a plugin
            self._selection.tell(f"{type(error).__name__}: {error}", error=True)

    def _execute(self, *, in_place: bool, **chosen: Any) -> str:
        """Execute a run; return the internal fault that ended it, or an empty text."""
        self.controls.stopped = False
        self._leave_idle()
        before, self._in_place = self._session.last, in_place
        try:
            self._session.run(in_place=in_place, **chosen)
        finally:
            job = self._session.last
            if job is not None and job is not before and job.run is not None:
                self._is_new = False
            self._rest()
        self._show_result()
        assert job is not None
        return job.error

    def _show_result(self) -> None:
        """Show the lines that a run ends with in the terminal, and what can be done next."""
        job = self._session.last
        if job is None or job.report is None:
            return
        self._keep.report = job.report
        recorded = job.next_step() if job.options.records else ""
        step = recorded or self._way_to_keep(job)
        again = "Run starts it again; another seed places the objects elsewhere."
        text = f"{job.lines(RESULT_WIDTH)}\n{step}\n\n{again}"
        self._selection.show_result(job.report.status, text)

    def _way_to_keep(self, job: Any) -> str:
        """Say how to record the same run."""
        if job.options.backend or job.options.continued is not None:
            return "To keep the next one: the same command with --record run.mcap."
        command = shlex.join(command_of(job.options, job.report.seed))
        if self._in_place:
            return (
                "It began where the arm was jogged, or where the run before had ended. From the "
                f"start, and recorded: {command}"
            )
        return (
            f"To keep it: {command}\nThen: bt-manip replay run.mcap, or bt-manip report run.mcap."
        )

    def _show_tree_of(self, request: RunRequest) -> None:
        """Show the tree of a request that does not run yet, with what is wrong with it."""
        parts, station = self._session.plugins.parts, self._session.station
        try:
            self.show_prepared(run := prepare(request, parts, station=station))
        except BtManipError as error:
            self._show_faulty(request, findings_of(error, request.tree.name))
            return
        if self._session.last is None:
            self._selection.tell(problem_of(self._named, nodes_of(run.tree)), error=True)

    def _show_faulty(self, request: RunRequest, errors: list[Any]) -> None:
        """Show the errors of a tree: at its nodes, if it only does not fit the cell."""
        parts, station = self._session.plugins.parts, self._session.station
        try:
            tree = load_source(
                request.tree, parts, request.settings, lambda: 0.0, reading=request.reading
            )
        except BtManipError:
            self.show_errors(request.tree.name, errors)
        else:
            assert station is not None  # it was built
            self.show_prepared(Run(request, tree, station), errors)

    def _rest(self) -> None:
        """Show the station, in which no tree runs."""
        self._leave_idle()
        if (station := self._session.station) is not None:
            self.begin_idle(station)
            self._loop = RunLoop(station.resting())
            self._loop.open()

    def _leave_idle(self) -> None:
        loop, self._loop = self._loop, None
        if loop is not None:
            loop.close()

    def _idle_tick(self) -> None:
        """Advance by a tick; the cell stands still after an exception, until the next request."""
        try:
            if self._loop is None:
                self.tick()
            else:
                self._loop.advance(self)
            self._is_new &= not self._jog.moved
        except (Exception, SystemExit) as error:
            self._loop = None
            text = f"the cell stands still: {error}; Reset builds it anew"
            self._selection.tell(text, error=True)

    def _save(self, name: str, q: Sequence[float]) -> str:
        """Save a configuration for the runs of this page and of others."""
        session = self._session
        path = session.options.configurations or SAVED
        save_configuration(path, name, q)
        session.options = replace(session.options, configurations=path)
        return (
            f"'{name}' is saved in {path.absolute()}; MoveToConfiguration finds it on this page, "
            f"and after bt-manip run TREE --configurations {path}"
        )


def command_of(options: RunOptions, seed: int) -> list[str]:
    """Return the words of the command that records the run of some options with a seed."""
    selected = chosen()
    plugins = [["--block", name] for name in sorted(selected.blocked)]
    plugins += [["--plugins-dir", str(folder)] for folder in selected.folders]
    given = given_options(replace(options, seed=seed, **NOT_REPEATED))
    words = [word for one in (*given, *plugins) for word in one]
    return ["bt-manip", "run", options.tree, *words, "--record", "run.mcap"]


def _selection(page: Any, session: Session) -> SessionPanel:
    """Return the panel that selects runs; at first, it shows the run of the command."""
    parts, request = session.plugins.parts, session.requested
    assert request is not None
    first = RunChoice(
        session.options.tree, str(request.scene), str(request.robot), request.seed, request.cycles
    )
    names = {
        "tree": parts.trees.names(), "scene": parts.scenes.names(), "robot": parts.robots.names()
    }  # fmt: skip

    def scene_of(tree: str) -> str:
        return str(session.request(tree=tree).scene)

    def seed_of(scene: str) -> int:
        return session.request(scene=scene, seed=None).seed

    return SessionPanel(page, names, first, scene_of, seed_of)
