"""Running a tree of the corpus, on a clock that only goes on between ticks."""

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bt_manip.bt.loading import load_tree, parse_tree
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.status import NodeStatus
from bt_manip.bt.tree import Tree
from bt_manip.exceptions import NodeError, TreeError
from tests.conformance.options import Options
from tests.support.corpus_leaves import Event, corpus_registry


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
    _tick(tree, options, clock, log, trace.ticks)
    trace.scopes = {path or tree.tree_id: _values(scope) for path, scope in tree.scopes.items()}
    return trace


def _tick(
    tree: Tree, options: Options, clock: Clock, log: list[Event], ticks: list[TickTrace]
) -> None:
    def step(act: Callable[[], NodeStatus | None], *, halt: bool = False) -> TickTrace:
        trace = TickTrace(None, [], [], {}, halt)
        log.clear()
        try:
            if not halt:
                tree._runtime.fire_timers()
                trace.events_before = list(log)
                log.clear()
            status = act()
            trace.root = None if status is None else status.name
        except NodeError as error:
            trace.error = str(error)
        trace.events, trace.values = list(log), _values(tree.blackboard)
        ticks.append(trace)
        return trace

    tick = tree.tick if options.once else tree.tick_exactly_once
    for number in range(1, options.ticks + 1):
        if number == options.halt_before and step(tree.halt, halt=True).error is not None:
            return
        done = step(tick)
        if done.error is not None or (options.stop_on_completion and done.root != "RUNNING"):
            return
        clock.time += options.sleep


def _values(scope: Any) -> dict[str, Any]:
    # Looked up by key, as the engine's own listing does: "@key" shows what the root holds.
    return {key: (scope.entry(key) or entry).value for key, entry in scope.entries.items()}
