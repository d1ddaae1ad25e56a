"""What the walk through a tree finds impossible never happens in the real engine."""

import json
from pathlib import Path

import pytest

from bt_manip.bt import NodeStatus, parse_source, parse_tree
from bt_manip.bt.analysis.facts import constants, written
from bt_manip.bt.analysis.uses import Uses
from bt_manip.bt.analysis.walk import Walk
from bt_manip.bt.traits import Traits
from bt_manip.exceptions import TreeError
from tests.conformance.options import options_in, parse_options
from tests.support.corpus_leaves import corpus_registry

ELEMENT = parse_source("<a/>").root
LEAVES = corpus_registry([])
LETTERS = {
    "S": NodeStatus.SUCCESS,
    "F": NodeStatus.FAILURE,
    "R": NodeStatus.RUNNING,
    "K": NodeStatus.SKIPPED,
}


def walked(text, options):
    tree = parse_tree(text, LEAVES, blackboard=options.blackboard(), strict=False)
    for node in tree.nodes:
        letters = str(node.given.get("outcomes", "S")).split(",") if node.ports else ()
        if "outcomes" in node.ports:
            node.traits = Traits(
                {LETTERS[one.strip()] for one in letters if one.strip() in LETTERS}
            )
    uses = Uses(tree.nodes, {id(node): ELEMENT for node in tree.nodes})
    walk = Walk({use.entry for use in (*uses.reads, *uses.writes)})
    outcomes = walk.visit(tree.nodes[0], written({}, constants(tree.scopes.values())))
    return walk, tree, outcomes


def impossible_in(walk, tree, outcomes, trace):
    """Give the events of a trace of the engine that the walk finds impossible."""
    names = {node.name: node for node in tree.nodes}
    impossible = {status.name for status in NodeStatus if status not in outcomes} - {"IDLE"}
    found = []
    for tick in trace["ticks"]:
        if tick["root"] in impossible:
            found.append(tick["root"])
        for name, kind, *_ in tick["events"]:
            if kind == "start" and id(names[name]) not in walk.incoming:
                found.append(f"{name} was ticked")
    return found


@pytest.mark.parametrize("name", ["nodes", "ports", "scripts", "timers"])
def test_what_the_engine_did_is_possible(name):
    judged = never = 0
    with (Path(__file__).with_name("traces") / f"{name}.jsonl").open() as lines:
        for case in map(json.loads, lines):
            options = parse_options(case["trace"].get("options") or options_in(case["xml"]))
            if options.substitutions or case["trace"].get("error"):
                continue
            try:
                walk, tree, outcomes = walked(case["xml"], options)
            except TreeError:
                continue  # the engine refuses some only when it comes to them
            assert impossible_in(walk, tree, outcomes, case["trace"]) == [], case["seed"]
            judged += 1
            never += len(walk.barred.keys() - walk.incoming.keys())
    assert judged >= 100
    assert never > 0
