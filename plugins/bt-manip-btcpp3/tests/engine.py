"""The leaves of the traces, and running a tree as the engine did."""

import functools
import gzip
import json
from pathlib import Path

from bt_manip.bt import (
    Action,
    BehaviourRegistry,
    Condition,
    Input,
    NodeStatus,
    Output,
    Problems,
    Status,
    SyncAction,
    parse_tree,
    read_tree,
    tree_to_xml,
)
from bt_manip.exceptions import NodeError, PortError
from bt_manip_btcpp3 import BTCPP3

TRACES = Path(__file__).with_name("traces.jsonl.gz")
STATUSES = {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING}


def cases():
    """Give the recorded trees: seed, xml, the tick before which it was halted, and its trace."""
    with gzip.open(TRACES, "rt") as lines:
        return [json.loads(line) for line in lines]


class _Cursor:
    _next = 0

    def _walk(self, event):
        letters = self.outcomes.split(",")
        cycles = self.mode == "cycle"
        letter = letters[self._next % len(letters) if cycles else min(self._next, len(letters) - 1)]
        self._next += 1
        self.log.append(f"{self.name}{event}{letter}")
        return STATUSES[letter]


def text_of(leaf, port):
    """Read a port; give ? where its entry is missing."""
    try:
        return leaf.read_port(port)
    except PortError:
        return "?"


@functools.cache
def leaves():
    """Give a registry with the leaves, and the list that they write to; it is made once."""
    log = []

    class Scripted(_Cursor, Action):
        outcomes, mode = Input(str), Input(str, default="hold")

        def update(self):
            return self._walk("r" if self.engine_status is NodeStatus.RUNNING else "s")

        def terminate(self, new_status):
            if new_status is Status.INVALID and self.engine_status is NodeStatus.RUNNING:
                self.log.append(f"{self.name}h")

    class SyncScripted(_Cursor, SyncAction):
        outcomes, mode = Input(str), Input(str, default="hold")

        def update(self):
            return self._walk("t")

    class ScriptedCondition(_Cursor, Condition):
        outcomes, mode = Input(str), Input(str, default="hold")

        def update(self):
            return self._walk("t")

    class Say(SyncAction):
        msg = Input(str)

        def update(self):
            self.log.append(f"{self.name}m{text_of(self, 'msg')}")
            return Status.SUCCESS

    class Put(SyncAction):
        value, out = Input(str), Output(str)

        def update(self):
            self.write_port("out", text_of(self, "value"))
            self.log.append(f"{self.name}w1")
            return Status.SUCCESS

    registry = BehaviourRegistry()
    registry.register_dialect(BTCPP3)
    for cls in (Scripted, SyncScripted, ScriptedCondition, Say, Put):
        cls.log = log
        registry.register(cls)
    return registry, log


def run(xml, ticks, halt=0, *, dialect="btcpp-3", whole=False):
    """Tick a tree, and give what the root and the leaves did in each tick.

    Args:
        xml: The document.
        ticks: How many ticks.
        halt: The tick in whose place the tree is halted; 0 for none.
        dialect: Its dialect.
        whole: Whether a tick goes on while the tree is woken up, as version 4 does.
    """
    registry, log = leaves()
    tree = parse_tree(xml, registry, dialect=dialect, strict=False)
    trace = []
    for number in range(1, ticks + 1):
        log.clear()
        try:
            if number == halt:
                tree.halt()
                root = "H"
            else:
                root = (tree.tick() if whole else tree.tick_exactly_once()).name[0]
        except NodeError:
            root = "X"
        trace.append(" ".join([root, *log]))
        if root == "X":
            break
    return trace


def converted(path, xml):
    """Give a document as version 4, and the findings of that."""
    path.write_text(xml)
    (registry, _), problems = leaves(), Problems()
    reading = read_tree(path, registry, dialect="btcpp-3", strict=False)
    reading.dialect.to_version_4(reading.document.root, reading.document, problems)
    return tree_to_xml(reading.usable_tree(), registry), list(problems)
