"""Stress tests: each fault at each phase of a tree, for several seeds, in parallel processes."""

import zlib
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from bt_manip.bt import NodeKind, NodeStatus
from bt_manip.evaluation import WorkerDiedError
from bt_manip.exceptions import ANY_BUT_INTERRUPT, did_you_mean, reason_of
from bt_manip.plugins import load_plugins
from bt_manip.record import ExecutionLog, Interval, LoggedNode
from bt_manip.runner import Run, RunLoop, RunObserver, prepare, request_of

from .faults.fault import FaultError
from .faults.injector import FaultInjector
from .faults.planned_fault import PlannedFault

TIMEOUT = 120.0
"""Simulated time after which a cycle hangs [s]."""

LATEST = 0.5
"""Largest share of the undisturbed duration of a phase after which a fault begins."""

Outcome = Literal["recovered", "failed", "dishonest", "hung", "died", "none"]
"""How a cycle with a fault ended.

``"recovered"``: SUCCESS, and the goal holds. ``"failed"``: not SUCCESS, or the run ended with an
error. ``"dishonest"``: SUCCESS although the goal does not hold. ``"hung"``: no end within
`TIMEOUT`. ``"died"``: the process died, again and again. ``"none"``: the fault could not
happen.
"""


@dataclass(frozen=True)
class StressPhase:
    """An action leaf that runs in an undisturbed cycle, or several of one path.

    Attributes:
        name: Its name in the tree, or its path where several leaves have that name.
        path: Its path in the tree.
        duration: Simulated time that it took [s].
    """

    name: str
    path: str
    duration: float


@dataclass(frozen=True)
class StressEpisode:
    """One fault at one phase with one seed."""

    fault: str
    phase: StressPhase
    seed: int

    def plan(self) -> PlannedFault:
        """Return the fault, for ``bt-manip run --fault``, with the time at which it begins."""
        label = f"{self.fault} {self.phase.path}".encode()
        rng = np.random.default_rng((self.seed, zlib.crc32(label)))
        after = round(LATEST * rng.uniform() * self.phase.duration, 3)
        return PlannedFault(self.fault, self.phase.path, after, 1)


@dataclass(frozen=True)
class StressResult:
    """How an episode ended.

    Attributes:
        episode: The episode.
        outcome: How the cycle with the fault ended.
        reason: Why it did not recover.
        next_reason: Why the undisturbed cycle after it did not reach its goal; empty if it did.
    """

    episode: StressEpisode
    outcome: Outcome
    reason: str = ""
    next_reason: str = ""

    @property
    def acceptable(self) -> bool:
        """Whether the tree was honest and ended, and the next cycle reached its goal."""
        return self.outcome not in ("dishonest", "hung", "died") and not self.next_reason


class StressTester:
    """Runs the episodes of one tree in this process; a station is built once for each seed.

    Args:
        tree: The tree as the user names it.
        choice: The `bt_manip.plugins.PluginSelection`; None: that of the environment.
        **options: Fields of `RunRequest`; controller and scene are the tree's by default.

    Attributes:
        faults: The registered faults.

    Raises:
        BtManipError: If a name is not registered.
    """

    def __init__(self, tree: str, *, choice: Any = None, **options: Any) -> None:
        self._tree = tree
        self._parts = parts = load_plugins(choice=choice, warn=lambda message: None).parts
        self.faults = parts.of("faults")
        self._request = request_of(tree, parts, **options)
        self._runs: dict[int, tuple[Run, dict[str, Any]]] = {}

    def phases(self) -> list[StressPhase]:
        """Return the action leaves that take time in an undisturbed cycle, in their order.

        Raises:
            FaultError: If the tree declares no goal, or does not reach it undisturbed.
        """
        run = self._prepared(0)
        if not run.tree.goal:
            raise FaultError(
                f"tree '{self._tree}' declares no goal to judge it by; add one to its main "
                '<BehaviorTree>, such as _goal="IsIn object={object} container=basket"'
            )
        times: dict[str, float] = {}
        names: dict[str, str] = {}

        def add(node: LoggedNode, interval: Interval, robot: str) -> None:
            if node.kind == NodeKind.ACTION and interval.end > interval.start:
                names[node.path] = node.name
                times[node.path] = times.get(node.path, 0.0) + interval.end - interval.start

        outcome, reason, _ = _run_cycle(run, 0, ExecutionLog(add))
        if outcome != "recovered":
            raise FaultError(f"tree '{self._tree}' fails without any fault: {reason}")
        counts = Counter(names.values())
        return [
            StressPhase(names[path] if counts[names[path]] == 1 else path, path, round(time, 3))
            for path, time in times.items()
        ]

    def warnings(self) -> Sequence[Any]:
        """Return what the checks found in the document of the tree."""
        return self._prepared(0).tree.warnings

    def run(self, episode: StressEpisode) -> StressResult:
        """Run a cycle with a fault, and an undisturbed one after it."""
        run = self._prepared(episode.seed)
        problems: list[str] = []
        injector = FaultInjector([episode.plan()], self.faults, episode.seed, problems.append)
        outcome, reason, aborted = _run_cycle(run, 0, injector, stop=lambda: bool(problems))
        if injector.missed:
            return StressResult(episode, "none", (problems or [""])[0])
        if aborted:  # as a user would, in a new run
            run = self._prepared(episode.seed)
        after, next_reason, _ = _run_cycle(run, 1)
        return StressResult(episode, outcome, reason, "" if after == "recovered" else next_reason)

    def _prepared(self, seed: int) -> Run:
        """Return a run in its initial state."""
        if seed not in self._runs:
            run = prepare(replace(self._request, seed=seed), self._parts)
            self._runs[seed] = run, run.get_state()
        run, state = self._runs[seed]
        run.set_state(state)
        return run


def _run_cycle(
    run: Run, cycle: int, *observers: RunObserver, stop: Callable[[], bool] = lambda: False
) -> tuple[Outcome, str, bool]:
    """Run one cycle; return how it ended, why not with success, and whether it was aborted."""
    end = run.station.cell.time + TIMEOUT
    try:
        with RunLoop(run, observers) as loop:
            ended = loop.cycle(cycle, stop=lambda: run.station.cell.time > end or stop())
    except ANY_BUT_INTERRUPT as error:
        return "failed", reason_of(error), True
    if ended is None:
        return "hung", f"no end within {TIMEOUT:g} s simulated", True
    if ended.succeeded:
        return "recovered", "", False
    dishonest = ended.status is NodeStatus.SUCCESS
    return "dishonest" if dishonest else "failed", ended.reason, False


def plan_episodes(
    tester: StressTester, seeds: int, faults: Sequence[str] = (), phases: Sequence[str] = ()
) -> list[StressEpisode]:
    """Return the episodes of a stress test, by seed, fault and phase.

    Args:
        tester: The tree.
        seeds: Number of seeds, from 0.
        faults: Names of faults; empty: all registered ones.
        phases: Names or paths of leaves; empty: all that run in an undisturbed cycle.

    Raises:
        UnknownPartError: If a fault is not registered.
        FaultError: If a leaf does not run, or the tree cannot be tested.
    """
    names = tester.faults.names()
    for name in faults:
        tester.faults.get(name)
    known = tester.phases()
    spelt = {text for phase in known for text in (phase.name, phase.path)}
    for name in phases:
        if name not in spelt:
            raise FaultError(f"no leaf '{name}' runs in this tree{did_you_mean(name, spelt)}")
    chosen = [one for one in known if not phases or {one.name, one.path} & set(phases)]
    return [
        StressEpisode(fault, phase, seed)
        for seed in range(seeds)
        for fault in names
        if not faults or fault in faults
        for phase in chosen
    ]


def lost_stress(episode: StressEpisode, error: WorkerDiedError) -> StressResult:
    """Return the result of an episode whose processes died."""
    return StressResult(episode, "died", str(error))
