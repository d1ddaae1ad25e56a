"""A run: a tree in a station, with its request, its state and the judge of its goal."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.bt import Tree
from bt_manip.files import noting

from .events import EventStream
from .goal import GoalJudge
from .interventions import Interventions
from .loop import RunLoop, Stop
from .notebook import html_table
from .observer import RunModifier, RunObserver
from .request import RunRequest
from .run_log import RunLog

if TYPE_CHECKING:
    from .station import Station

AT_ONCE = 0.1
"""Simulated time within which a cycle fails at once [s]."""

MAX_FAILURES = 10
"""Number of cycles in a row that fail at once after which a run ends."""


@dataclass(eq=False)
class Run:
    """A tree that is ready to run, or to continue, in a station.

    Attributes:
        cycle: The present cycle, or the next one.
        goal: Judges the tree's goal; it has judged a cycle when `cycle_ended` is called.
        identity: What identifies the run besides its request, by the fields of its report:
            ``foreign``, ``agent``, ``episode``.
        files: SHA-256 of the files that it has loaded beside those of its station, by name.
        modifiers: The modifiers of its request.
        interventions: Takes requests to pull bodies and to set the statuses of nodes.
        log: Control steps and digest of the present or last execution.
        events: Makes its events.
        stop: Returns whether the run has to end; whoever pauses it checks this often.
        start: State of the station to which each further cycle returns, unless the tree continues;
            None: the cell stays as it is, as that of a real robot does.
        begun: Whether a cycle has begun since that state.
        ended_early: Why it ended before its last cycle; empty where it did not.
    """

    request: RunRequest
    tree: Tree
    station: "Station"
    cycle: int = 0
    identity: dict[str, Any] = field(default_factory=dict)
    files: dict[str, str] = field(default_factory=dict)
    modifiers: Sequence[RunModifier] = ()

    def __post_init__(self) -> None:
        """Prepare to judge the tree's goal."""
        self.goal = GoalJudge(self.tree, self.station.cell)
        self.interventions = Interventions(self.tree, self.station)
        self.log: RunLog
        self.events: EventStream
        self.stop: Stop = lambda: False
        self.start: dict[str, Any] | None = None
        self.begun = False
        self.ended_early = ""
        self._initial: dict[str, Any] | None = None

    @property
    def all_files(self) -> dict[str, str]:
        """SHA-256 of the files that it and its station have loaded, by name."""
        return self.station.files | self.files

    @property
    def absent(self) -> list[str]:
        """Varied quantities of objects of which none was in the cell in this cycle."""
        absent, start = self.station.randomizer.absent, "scene.objects."
        return [
            name
            for name in self.request.varied
            if name.startswith(start) and name.removeprefix(start).rpartition(".")[0] in absent
        ]

    def _repr_html_(self) -> str:
        """Show the request, the present cycle and the tree in a notebook."""
        request, cell = self.request, self.station.cell
        rows = {
            "tree": request.tree.name,
            "robots": ", ".join(self.station.robots),
            "scene": str(request.scene),
            "seed": request.seed,
            "cycle": f"{self.cycle + 1} of {request.cycles or 'any number'}",
            "time": f"{cell.time:.2f} s",
        }
        return html_table("Run", rows) + self.tree._repr_svg_()

    def execute(self, observers: Sequence[RunObserver] = (), *, stop: Stop = lambda: False) -> None:
        """Run the requested cycles.

        Args:
            observers: Called as `RunObserver` documents.
            stop: Called once per tick; when it returns True, the tree is halted, the arms are
                stopped and the run ends.

        Raises:
            Exception: Any exception of a behaviour, a controller or an observer, after `run_ended`
                has been called for all observers.
        """
        self.stop, request = stop, self.request
        station, failures = self.station, 0
        with noting(station.files), RunLoop(self, observers) as loop:
            while request.cycles == 0 or self.cycle < request.cycles:
                begin = station.cell.time
                ended = loop.cycle(self.cycle, stop=lambda: self.stop())
                if ended is None:
                    return
                at_once = not ended.succeeded and station.cell.time - begin < AT_ONCE
                failures = failures + 1 if at_once else 0
                if failures == MAX_FAILURES and self.cycle != request.cycles:
                    self.ended_early = (
                        f"{failures} cycles in a row failed within {AT_ONCE:g} s: {ended.reason}"
                    )
                    return

    def begin_episode(self, episode: int, seed: int | None = None) -> None:
        """Return to the initial state, from which `execute` then runs one episode.

        An episode is one run of the root. It depends only on the request and on its number, from
        which the samples and the state of the station's random generator follow, not on what ran
        before; so it is the same in any process, bit for bit.

        Args:
            episode: Its number, which is also that of its cycle.
            seed: Another seed for the request; None: the present one.

        Raises:
            CellError: If an object of the scene finds no free pose with this seed.
        """
        if self._initial is None:
            self._initial = self.get_state()
        self.set_state(self._initial)
        self.begun = False
        if seed is not None:
            self.request = replace(self.request, seed=seed)
        self.station.reseed(self.request.seed)
        rng = np.random.default_rng((self.request.seed, episode))
        self.station.rng.bit_generator.state = rng.bit_generator.state
        self.request = replace(self.request, cycles=episode + 1)
        self.cycle = episode

    def get_state(self) -> dict[str, Any]:
        """Return the state of the run as plain data.

        Taken between two ticks, as in an observer's `after_tick`, it can be continued by another
        run of the same request, also in another process.
        """
        return {
            "cycle": self.cycle,
            "station": self.station.get_state(),
            "tree": self.tree.get_state(),
            "goal": self.goal.get_state(),
            "interventions": self.interventions.get_state(),
            "begun": self.begun,
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of `get_state`; `execute` continues from there bit for bit.

        Raises:
            BtManipError: If the state is of another tree, or has objects that are not known here.
        """
        self.station.set_state(state["station"])
        self.tree.set_state(state["tree"])
        self.goal.set_state(state["goal"])
        self.interventions.set_state(state.get("interventions", {}))
        self.cycle, self.begun = state["cycle"], state.get("begun", True)
