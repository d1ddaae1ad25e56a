"""Running a tree of the corpus, on a clock that only goes on between ticks."""

import functools
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bt_manip.bt.loading import load_tree, parse_tree
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.status import RUNNING
from bt_manip.bt.tree import Tree
from bt_manip.exceptions import NodeError, TreeError
from tests.conformance.leaves import Event, corpus_registry
from tests.conformance.options import Options


@dataclass
class TickTrace:
    """What happened in one tick, or in one halt.

    Attributes:
        root: The root's status by name; None after an exception or a halt.
        events: What happened to the leaves.
        events_before: What timers did between the last tick and this one.
        values: The values of the root's blackboard.
        halt: Whether this was a halt.
        error: The exception, if there was one.
    """

    root: str | None
    events: list[Event]
    events_before: list[Event]
    values: dict[str, Any]
    halt: bool = False
    error: str | None = None


@dataclass
class EngineTrace:
    """What happened in one run.

    Attributes:
        error: Why the document was rejected, if it was.
        ticks: Its ticks and halts.
        scopes: The final values of every scope; the root's is named by its tree.
    """

    error: str | None = None
    ticks: list[TickTrace] = field(default_factory=list)
    scopes: dict[str, dict[str, Any]] = field(default_factory=dict)


@functools.cache
def _leaves() -> tuple[BehaviourRegistry, list[Event]]:
    """Return the leaves, made once for all runs, and the log that they write."""
    log: list[Event] = []
    return corpus_registry(log), log


class Clock:
    """A clock that stands still until a test moves it."""

    def __init__(self) -> None:
        self.time = 0.0

    def __call__(self) -> float:
        return self.time


def run(document: str | Path, options: Options) -> EngineTrace:
    """Read a document as the engine does, and run it.

    Args:
        document: A file, or a text.
        options: How to run it.
    """
    registry, log = _leaves()
    log.clear()
    clock = Clock()
    read: Any = load_tree if isinstance(document, Path) else parse_tree
    trace = EngineTrace()
    try:
        tree = read(
            document,
            registry,
            clock=clock,
            blackboard=options.blackboard(),
            substitutions=options.substitutions,
            strict=False,
        )
    except TreeError as error:
        trace.error = str(error)
        return trace
    _tick(tree, options, clock, log, trace)
    trace.scopes = {path or tree.tree_id: _values(scope) for path, scope in tree.scopes.items()}
    return trace


def _tick(tree: Tree, options: Options, clock: Clock, log: list[Event], trace: EngineTrace) -> None:
    for number in range(1, options.ticks + 1):
        if number == options.halt_before:
            log.clear()
            problem = None
            try:
                tree.halt()
            except NodeError as error:
                problem = str(error)
            values = _values(tree.blackboard)
            trace.ticks.append(TickTrace(None, list(log), [], values, halt=True, error=problem))
            if problem is not None:
                return
        log.clear()
        try:
            tree._runtime.fire_timers()
            before = list(log)
            log.clear()
            status = tree.tick() if options.once else tree.tick_exactly_once()
        except NodeError as error:
            values = _values(tree.blackboard)
            trace.ticks.append(TickTrace(None, list(log), before, values, error=str(error)))
            return
        values = _values(tree.blackboard)
        trace.ticks.append(TickTrace(status.name, list(log), before, values))
        if options.stop_on_completion and status is not RUNNING:
            return
        clock.time += options.sleep


def _values(scope: Any) -> dict[str, Any]:
    # Looked up by key, as the engine's own listing does: "@key" shows what the root holds.
    return {key: (scope.entry(key) or entry).value for key, entry in scope.entries.items()}
