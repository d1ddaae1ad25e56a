"""Runs of whole trees, with assertions on their end states in the physics."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.plugins import Plugins
from bt_manip.registry import Parts
from bt_manip.runner import Run, RunObserver, Station, prepare, request_of
from bt_manip.testing.coverage import TreeCoverage
from bt_manip.testing.history import History, explain
from bt_manip.testing.tree_reading import located

EndState = Callable[[Station], object]
"""Function that checks a station at the end of a cycle: it raises or returns False when the check
fails. It may step the simulation; the station is restored afterwards."""


@dataclass
class _Judge(RunObserver):
    """Observer that checks the result and the end state of each cycle."""

    end_state: EndState | None
    problems: list[str] = field(default_factory=list)
    cycles: int = 0

    def run_started(self, run: Run) -> None:
        self._station, self._history = run.station, History(run.tree)
        run.tree.observers.append(self._history)

    def cycle_started(self, cycle: int) -> None:
        self._cycle = cycle
        self._history.tick = 0
        self._history.changes.clear()

    def after_tick(self) -> None:
        self._history.tick += 1

    def cycle_ended(self, status: str, reason: str) -> None:
        self.cycles += 1
        if status != "SUCCESS":
            self.problems.append(f"cycle {self._cycle} failed: {reason}\n{explain(self._history)}")
        elif self.end_state is not None:
            self._judge(self.end_state)

    def _judge(self, end_state: EndState) -> None:
        state = self._station.get_state()
        try:
            if end_state(self._station) is False:
                raise AssertionError(f"{getattr(end_state, '__name__', 'the condition')} is False")
        except AssertionError as error:
            self.problems.append(
                f"cycle {self._cycle} did not end as it should: {error}\n{explain(self._history)}"
            )
        finally:
            self._station.set_state(state)


def run_tree(
    tree: str | Path,
    parts: Parts,
    *,
    end_state: EndState | None = None,
    cycles: int = 1,
    seed: int = 0,
    settings: Mapping[str, Any] | None = None,
    folder: Path | None = None,
    coverage: TreeCoverage | None = None,
    **choice: Any,
) -> None:
    """Run a tree and assert that every cycle succeeds with the right end state.

    Args:
        tree: A registered name, ``path.xml`` or ``path.py:function``.
        parts: The registered parts.
        end_state: Check at the end of each cycle, beside the tree's result.
        cycles: Number of runs.
        seed: Seed of all randomness.
        settings: Values of the tree's keys.
        folder: Base of relative paths; the current folder when None.
        coverage: Collects the coverage, if given.
        **choice: Further fields of `bt_manip.runner.RunRequest`: ``robot``, ``controller``,
            ``scene``, ...; defaults are those that the tree was registered with.

    Raises:
        AssertionError: When cycles fail or have another end state, with the reasons.
        BtManipError: When the tree cannot run.
    """
    __tracebackhide__ = True
    texts = {key: str(value) for key, value in (settings or {}).items()}
    request = request_of(
        located(tree, folder), parts, cycles=cycles, seed=seed, settings=texts, **choice
    )
    run = prepare(request, parts)
    if coverage is not None:
        coverage.watch(run.tree)
    judge = _Judge(end_state)
    run.execute([judge])
    good = judge.cycles - len(judge.problems)
    if good < cycles:
        raise AssertionError(
            f"{good} of {cycles} cycles of '{tree}' ended as they should\n"
            + "\n".join(judge.problems)
        )


def tree_runs(plugins: Plugins, where: str | Path, options: Mapping[str, Any]) -> list[Any]:
    """Return the runs of all trees of a plugin or a folder, as ``(name, run(parts, coverage))``."""
    if Path(where).is_dir():
        trees = {path.stem: str(path) for path in sorted(Path(where).glob("*.xml"))}
    else:
        trees = {name: name for name in plugins.working(str(where)).provides.get("trees", ())}
    if not trees:
        raise BtManipError(f"'{where}' has no trees")
    for key in ("end_states", "settings"):
        for name in options[key]:
            if name not in trees:
                raise BtManipError(f"'{where}' has no tree '{name}'{did_you_mean(name, trees)}")

    def run(place: str, name: str, parts: Parts, coverage: Any) -> None:
        run_tree(
            place, parts, end_state=options["end_states"].get(name), coverage=coverage,
            settings=options["settings"].get(name), **options["run"],
        )  # fmt: skip

    return [(name, partial(run, place, name)) for name, place in trees.items()]
