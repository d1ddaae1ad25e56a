"""Details in which random trees once differed from BehaviorTree.CPP 4.10.0.

The expected traces are what the engine did with the very same text.
"""

import pytest

from bt_manip.bt.loading import read_tree_text
from tests.conformance.compare import differences
from tests.conformance.options import options_in, parse_options
from tests.conformance.runner import run

MAIN = ' main_tree_to_execute="Main"'
SUBTREE = '<BehaviorTree ID="T"><AlwaysSuccess/></BehaviorTree>'


def document(body, options="", others="", main=MAIN):
    return (
        f'<root BTCPP_format="4"{main}><!-- conformance: {options} -->'
        f'<BehaviorTree ID="Main">{body}</BehaviorTree>{others}</root>'
    )


def compare(text, trace):
    return differences(run(text, parse_options(options_in(text))), trace)


def once(root, *events, **scopes):
    """Give the trace of one tick."""
    tick = {"root": root, "events": list(events)}
    if root is None:
        tick["error"] = "it raised"
    final = {name: {k: {"value": v} for k, v in scope.items()} for name, scope in scopes.items()}
    return {"ticks": [tick], "final_blackboard": final or {"Main": {}}}


def leaf(name, **values):
    """Give the line of a trace for the tick of a leaf."""
    return {"node": name, "ev": "tick", **values}


def without_entries(trace):
    """Leave the final blackboard out of a trace."""
    return {"ticks": trace["ticks"]}


def model(levels):
    return f"<TreeNodesModel>{'<a>' * levels}{'</a>' * levels}</TreeNodesModel>"


def tree_s(body):
    return f'<BehaviorTree ID="S">{body}</BehaviorTree>'


IN_S = '<Sequence name="s"><AlwaysSuccess/><AlwaysSuccess/></Sequence>'
STUCK = '<Sequence _onHalted="nope = 1"><Scripted name="a" outcomes="R"/></Sequence>'
ONE_KEY = '<LoopDouble queue="{u}" value="{u}"><SetOutInt value="1" out="{u}"/></LoopDouble>'
SET_S = tree_s('<SetOutInt name="a" value="7" out="{u}"/>')
TWO_TYPES = (
    '<Sequence><SetOutInt name="a" value="1" out="{v}"/>'
    '<SetOutDouble name="b" value="1" out="{v}"/></Sequence>'
)
TWICE_IN_A_MODEL = (
    '<TreeNodesModel><SubTree ID="T"><output_port name="z" default="out"/>'
    '<input_port name="z" default="in"/></SubTree></TreeNodesModel>'
)
TREE_IN_AN_UNUSED_TREE = (
    '<BehaviorTree ID="U"><Inverter><BehaviorTree ID="V"><AlwaysSuccess/></BehaviorTree>'
    "</Inverter></BehaviorTree>"
)
LARGE = (
    '<Sequence><Script code="n = n + 1"/><Repeat num_cycles="{n}"><AlwaysSuccess/></Repeat>'
    "</Sequence>"
)
ROOT_KEY = '<Sequence><SubTree ID="S" name="t" u="{@x}"/><Script code="y := x"/></Sequence>'
X_OF_ROOT = '<SubTree ID="S" name="t" x="{@x}"/>'
EMPTY_LOOP = '<LoopInt queue="{x}" if_empty="FAILURE"><AlwaysSuccess/></LoopInt>'
EXPLICIT = document('<ReactiveSequence><Action ID="AlwaysSuccess"/></ReactiveSequence>')

REFUSED = {
    "the ports of a replaced node still declare their entries": document(
        TWO_TYPES, "subst.?=AlwaysSuccess"
    ),
    "a decorator cannot replace a node with two children": document(IN_S, "subst.s=Inverter"),
    "an empty main tree means none of two": document(
        "<AlwaysSuccess/>", others=SUBTREE, main=' main_tree_to_execute=""'
    ),
    "a JSON list of doubles takes no truth value": document(
        '<SetOutVecDouble value="json:[true]" out="{v}"/>'
    ),
    "a JSON list of doubles takes no number that is too large": document(
        '<SetOutVecDouble value="json:[1e400]" out="{v}"/>'
    ),
    "explicit elements below a reactive sequence": EXPLICIT,
    "a comment does not end within its opening": document("<AlwaysSuccess/>", others="<!--->"),
    "an explicit element with the ID SubTree names a tree": document('<Action ID="SubTree"/>'),
    "elements nest no deeper than 498 levels": document("<AlwaysSuccess/>", others=model(497)),
    "of two ports with one key the last one declares the entry": document(ONE_KEY),
}

DETAILS = {
    "a substituted node reads a port that the replaced node has, too": (
        document('<Scripted name="a" outcomes="F"/>', "subst.a=SyncScripted"),
        once("FAILURE", leaf("a", outcome="F")),
    ),
    "a substituted node has no default of a port that the replaced node lacks": (
        document('<Script name="a" code="x := 1"/>', "subst.a=Scripted"),
        once(None),
    ),
    "a node that replaces a sub-tree has no defaults either": (
        document('<SubTree ID="T" name="t"/>', "subst.t=Scripted", SUBTREE),
        once(None),
    ),
    "an empty main tree means the only tree": (
        document("<AlwaysSuccess/>", main=' main_tree_to_execute=""'),
        once("SUCCESS"),
    ),
    "of a port that stands twice in a model the output counts more than the input": (
        document('<SubTree ID="T" name="t"/>', others=SUBTREE + TWICE_IN_A_MODEL),
        once("SUCCESS", Main={}, t={"z": "out"}),
    ),
    "a JSON list of integers takes truth values": (
        document('<SetOutVecInt name="a" value="json:[true]" out="{v}"/>'),
        once("SUCCESS", leaf("a", wrote=[1]), Main={"v": [1]}),
    ),
    "a remap to a root key reads the root and writes beside it": (
        document(ROOT_KEY, "bb.int.x=3", SET_S),
        once("SUCCESS", leaf("a", wrote=7), Main={"x": 3, "y": 3, "@x": 3}, t={}),
    ),
    "a port does not take a number that a script made too large for its entry": (
        document(LARGE, "bb.int.n=2147483647"),
        once(None, Main={"n": 2147483648}),
    ),
    "an enumeration takes numbers without a name": (
        document('<CheckInColor name="a" in="4"/>'),
        once("SUCCESS", leaf("a", read=4)),
    ),
    "an exception while the tree is halted ends the run": (
        document(STUCK, "halt_before=2; ticks=3"),
        {
            "ticks": [
                {"root": "RUNNING", "events": [{"node": "a", "ev": "start", "outcome": "R"}]},
                {"op": "haltTree", "error": "it raised", "events": [{"node": "a", "ev": "halt"}]},
            ]
        },
    ),
    "a tree inside a tree that nothing uses is not found": (
        document("<AlwaysSuccess/>", others=TREE_IN_AN_UNUSED_TREE),
        once("SUCCESS"),
    ),
    "elements nest 498 levels deep": (
        document("<AlwaysSuccess/>", others=model(496)),
        once("SUCCESS"),
    ),
    "a script cannot create a root key through a remap": (
        document(X_OF_ROOT, others=tree_s('<Script code="x := 2"/>')),
        without_entries(once(None)),
    ),
    "a loop over a root key that does not exist is empty": (
        document(X_OF_ROOT, others=tree_s(EMPTY_LOOP)),
        without_entries(once("FAILURE")),
    ),
    "SetBlackboard takes any number of signs of the root": (
        document('<SetBlackboard value="7" output_key="@@x"/>'),
        once("SUCCESS", Main={"x": "7"}),
    ),
}


@pytest.mark.parametrize("text", REFUSED.values(), ids=REFUSED)
def test_a_document_is_refused_as_by_the_engine(text):
    assert compare(text, {"error": "rejected"}) == []


@pytest.mark.parametrize(("text", "trace"), DETAILS.values(), ids=DETAILS)
def test_a_detail_is_as_in_the_engine(text, trace):
    assert compare(text, trace) == []


@pytest.mark.parametrize(("value", "written"), [("true", 1), ("false", None)])
def test_an_integer_entry_takes_the_truth_value_true_only(value, written):
    body = (
        '<Sequence><SetOutInt name="a" value="5" out="{@z}"/>'
        f'<SetOutBool name="b" value="{value}" out="{{@z}}"/></Sequence>'
    )
    events = [leaf("a", wrote=5), *([leaf("b", wrote=written)] if written else [])]
    text = document('<SubTree ID="S" name="t"/>', "bb.string.z=s", tree_s(body))
    trace = once("SUCCESS" if written else None, *events, Main={"z": written or 5}, t={})

    assert compare(text, trace) == []


def test_users_are_only_warned_of_explicit_elements_below_a_reactive_sequence(bench):
    reading = read_tree_text(EXPLICIT, bench.registry)

    assert reading.tree is not None and not reading.errors
    assert any("<AlwaysSuccess .../>" in str(warning) for warning in reading.warnings)


def test_the_same_name_shorthand_in_a_model_means_the_name_and_is_warned_of(bench):
    model = '<TreeNodesModel><SubTree ID="T"><input_port name="h" default="{=}"/></SubTree>'
    text = document('<SubTree ID="T" name="t"/>', others=SUBTREE + model + "</TreeNodesModel>")

    reading = read_tree_text(text, bench.registry)

    assert reading.tree.scopes["t"].remapped == {"h": "h"}
    assert any("write {h}" in str(warning) for warning in reading.warnings)


def test_a_tree_inside_a_tree_is_an_error_for_users_whether_it_is_used_or_not(bench):
    inside = '<BehaviorTree ID="V"><AlwaysSuccess/></BehaviorTree>'
    unused = f'<BehaviorTree ID="U">{inside}</BehaviorTree>'

    for text in (document(inside), document("<AlwaysSuccess/>", others=unused)):
        errors = read_tree_text(text, bench.registry).errors
        assert ["cannot stand inside another" in str(error) for error in errors] == [True]
