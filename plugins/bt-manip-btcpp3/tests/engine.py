"""The leaves of the traces, and running a tree as the engine did."""

import functools
import gzip
import json
from pathlib import Path

from bt_manip.bt import (
    Input,
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
from tests.support.corpus_leaves import corpus_registry

TRACES = Path(__file__).with_name("traces.jsonl.gz")


def cases():
    """Give the recorded trees: seed, xml, the tick before which it was halted, and its trace."""
    with gzip.open(TRACES, "rt") as lines:
        return [json.loads(line) for line in lines]


def text_of(leaf, port):
    """Read a port; give ? where its entry is missing."""
    try:
        return leaf.read_port(port)
    except PortError:
        return "?"


@functools.cache
def leaves():
    """Give a registry with the leaves, and the list of their events; it is made once."""
    log = []

    class Say(SyncAction):
        msg = Input(str)

        def update(self):
            log.append({"node": self.name, "ev": "m", "outcome": text_of(self, "msg")})
            return Status.SUCCESS

    class Put(SyncAction):
        value, out = Input(str), Output(str)

        def update(self):
            self.write_port("out", text_of(self, "value"))
            log.append({"node": self.name, "ev": "w", "outcome": 1})
            return Status.SUCCESS

    registry = corpus_registry(log)
    registry.register_dialect(BTCPP3)
    for cls in (Say, Put):
        registry.register(cls)
    return registry, log


def short(event):
    """Give an event as the traces have it: the name, the first letter of its kind, its outcome."""
    return f"{event['node']}{event['ev'][0]}{event.get('outcome', '')}"


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
        trace.append(" ".join([root, *map(short, log)]))
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
