"""Contract of trees, scenes and robots: their runs repeat and continue bit for bit."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import zip_longest
from typing import Any

from bt_manip.evaluation import EpisodeId, EpisodeResult, EpisodeWorker, Evaluation, run_episodes
from bt_manip.registry import Parts
from bt_manip.runner import Run, RunObserver, prepare, request_of

CYCLE_TIMEOUT = 120.0  # [s] simulated for a cycle, after which a run is interrupted
SHORT = 2.0  # [s] simulated, after which a short run is interrupted
EVERY = 5  # ticks between two states
EPISODES = 6
WORKERS = 3


@dataclass(frozen=True)
class RunCase:
    """Runs of a tree, in a scene, with a robot.

    Attributes:
        name: What is checked, for messages: ``"scene NAME"``, ...
        tree: The tree, as in ``bt-manip run``.
        parts: The registered parts.
        options: Fields of `bt_manip.runner.RunRequest`.
    """

    name: str
    tree: str
    parts: Parts
    options: Mapping[str, Any] = field(default_factory=dict)

    def make(self, **options: Any) -> Run:
        """Return a new run, in a station of its own."""
        return prepare(request_of(self.tree, self.parts, **{**self.options, **options}), self.parts)


def goes_on_from_its_state(case: RunCase) -> None:
    """Check that a new run continues from a state in its first seconds, bit for bit."""
    _continue(case, (0.6,), 1, SHORT)


def goes_on_from_its_state_at_any_time(case: RunCase) -> None:
    """Check that new runs continue from states at many moments of two cycles, bit for bit."""
    shares = (0.03, 0.1, 0.2, 0.3, 0.4, 0.55, 0.7, 0.8, 0.9, 0.97)
    _continue(case, shares, 2, 2 * CYCLE_TIMEOUT)


def has_the_same_episodes_in_any_process(case: RunCase) -> None:
    """Check that episodes in two orders, and with one and three workers, have the same results."""
    make = partial(EpisodeWorker, Evaluation(case.tree, case.options))
    episodes = [EpisodeId(0, number) for number in range(EPISODES)]

    def results(order: list[EpisodeId], workers: int) -> dict[int, EpisodeResult]:
        found = run_episodes(make, order, workers)
        return {one.episode: replace(one, wall_s=0.0) for one in found}

    forth = results(episodes, 1)
    others = {
        "in reversed order": results(episodes[::-1], 1),
        f"with {WORKERS} workers": results(episodes, WORKERS),
    }
    for how, found in others.items():
        different = [number for number in forth if found[number] != forth[number]]
        assert not different, f"the episodes {different} of '{case.name}' differ {how}"


SHORT_RUN_CONTRACT: tuple[Callable[[RunCase], None], ...] = (goes_on_from_its_state,)
"""Check that takes a second; it raises `AssertionError` if it fails."""

RUN_CONTRACT: tuple[Callable[[RunCase], None], ...] = (
    goes_on_from_its_state_at_any_time,
    has_the_same_episodes_in_any_process,
)
"""Checks of whole tasks, which take longer; each raises `AssertionError` if it fails."""


class _Watch(RunObserver):
    """Keeps the digest after each tick, and states.

    Attributes:
        digests: The digests.
        states: Some states, with their digests, as JSON, by the number of ticks.
        end: The state at the end, as JSON.
    """

    def __init__(self, every: int = 0, digest: str = "") -> None:
        self._every, self._digest = every, digest
        self.digests: list[str] = []
        self.states: dict[int, str] = {}
        self.end = ""

    def run_started(self, run: Run) -> None:
        """Begin or continue the digest."""
        self._run = run
        run.log.keep_digest(bytes.fromhex(self._digest))

    def after_tick(self) -> None:
        """Keep the digest, and the state if it is time."""
        digest = self._run.log.digest.hex()
        self.digests.append(digest)
        tick = len(self.digests)
        if self._every and tick % self._every == 1:
            self.states[tick] = json.dumps([self._run.get_state(), digest])


def _execute(run: Run, watch: _Watch, end: float) -> _Watch:
    """Execute a run, which is interrupted at a simulated time [s]."""
    run.execute([watch], stop=lambda: run.station.cell.time > end)
    watch.end = json.dumps(run.get_state(), sort_keys=True)
    return watch


def _continue(case: RunCase, shares: tuple[float, ...], cycles: int, end: float) -> None:
    """Check that new runs continue from states after these shares of the ticks."""
    whole = _execute(case.make(cycles=cycles), _Watch(EVERY), end)
    count = len(whole.digests)
    taken = [tick for tick in whole.states if tick < count]
    for tick in sorted({min(taken, key=lambda n: abs(n - s * count)) for s in shares if taken}):
        state, digest = json.loads(whole.states[tick])
        run = case.make(cycles=cycles)
        run.set_state(state)
        rest = _execute(run, _Watch(digest=digest), end)
        what = f"'{case.name}', continued from its state after {tick} of {count} ticks,"
        _compare(whole, rest, tick, what)


def _compare(expected: _Watch, found: _Watch, start: int, what: str) -> None:
    """Check that two executions have the same bits from a tick on."""
    for tick, (one, other) in enumerate(
        zip_longest(expected.digests[start:], found.digests), start + 1
    ):
        assert one == other, f"{what} differs from tick {tick} on"
    assert expected.end == found.end, f"{what} ends in another state"
