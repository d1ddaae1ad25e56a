"""Details in which random trees once differed from BehaviorTree.CPP 4.10.0.

The expected traces are what the engine did with the very same text.
"""

import pytest

from bt_manip.bt.loading import read_tree_text
from tests.conformance.compare import differences
from tests.conformance.options import options_in, parse_options
from tests.conformance.runner import run

REJECTED = {"error": "rejected"}
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


def test_a_substituted_node_reads_a_port_that_the_replaced_node_has_too():
    text = document('<Scripted name="a" outcomes="F"/>', "subst.a=SyncScripted")

    assert compare(text, once("FAILURE", {"node": "a", "ev": "tick", "outcome": "F"})) == []


def test_a_substituted_node_has_no_default_of_a_port_that_the_replaced_node_lacks():
    text = document('<Script name="a" code="x := 1"/>', "subst.a=Scripted")

    assert compare(text, once(None)) == []


def test_a_node_that_replaces_a_subtree_has_no_defaults_either():
    text = document('<SubTree ID="T" name="t"/>', "subst.t=Scripted", SUBTREE)

    assert compare(text, once(None)) == []


def test_the_ports_of_a_replaced_node_still_declare_their_entries():
    nodes = '<SetOutInt name="a" value="1" out="{v}"/><SetOutDouble name="b" value="1" out="{v}"/>'
    text = document(f"<Sequence>{nodes}</Sequence>", "subst.?=AlwaysSuccess")

    assert compare(text, REJECTED) == []


def test_a_decorator_cannot_replace_a_node_with_two_children():
    body = '<Sequence name="s"><AlwaysSuccess/><AlwaysSuccess/></Sequence>'

    assert compare(document(body, "subst.s=Inverter"), REJECTED) == []


def test_an_empty_main_tree_means_the_only_tree():
    text = document("<AlwaysSuccess/>", main=' main_tree_to_execute=""')

    assert compare(text, once("SUCCESS")) == []


def test_an_empty_main_tree_means_none_of_two():
    text = document("<AlwaysSuccess/>", others=SUBTREE, main=' main_tree_to_execute=""')

    assert compare(text, REJECTED) == []


def test_of_a_port_that_stands_twice_in_a_model_the_output_counts_more_than_the_input():
    model = (
        '<TreeNodesModel><SubTree ID="T"><output_port name="z" default="out"/>'
        '<input_port name="z" default="in"/></SubTree></TreeNodesModel>'
    )
    text = document('<SubTree ID="T" name="t"/>', others=SUBTREE + model)

    assert compare(text, once("SUCCESS", Main={}, t={"z": "out"})) == []


@pytest.mark.parametrize("items", ["true", "1e400", "NaN", "Infinity"])
def test_a_json_list_of_doubles_takes_numbers_only(items):
    text = document(f'<SetOutVecDouble value="json:[{items}]" out="{{v}}"/>')

    assert compare(text, REJECTED) == []


def test_a_json_list_of_integers_takes_truth_values():
    text = document('<SetOutVecInt name="a" value="json:[true]" out="{v}"/>')
    event = {"node": "a", "ev": "tick", "wrote": [1]}

    assert compare(text, once("SUCCESS", event, Main={"v": [1]})) == []


def test_a_remap_to_a_root_key_reads_the_root_and_writes_beside_it():
    inner = '<BehaviorTree ID="T"><SetOutInt name="a" value="7" out="{u}"/></BehaviorTree>'
    body = '<Sequence><SubTree ID="T" name="t" u="{@x}"/><Script code="y := x"/></Sequence>'
    event = {"node": "a", "ev": "tick", "wrote": 7}

    found = compare(
        document(body, "bb.int.x=3", inner),
        once("SUCCESS", event, Main={"x": 3, "y": 3, "@x": 3}, t={}),
    )

    assert found == []


def test_a_port_does_not_take_a_number_that_a_script_made_too_large_for_its_entry():
    body = (
        '<Sequence><Script code="n = n + 1"/><Repeat num_cycles="{n}"><AlwaysSuccess/></Repeat>'
        "</Sequence>"
    )

    text = document(body, "bb.int.n=2147483647")

    assert compare(text, once(None, Main={"n": 2147483648})) == []


def test_an_enumeration_takes_numbers_without_a_name():
    text = document('<CheckInColor name="a" in="4"/>')

    assert compare(text, once("SUCCESS", {"node": "a", "ev": "tick", "read": 4})) == []


EXPLICIT = document('<ReactiveSequence><Action ID="AlwaysSuccess"/></ReactiveSequence>')


def test_the_engine_rejects_explicit_elements_below_a_reactive_sequence():
    assert compare(EXPLICIT, REJECTED) == []


def test_users_are_only_warned_of_explicit_elements_below_a_reactive_sequence(bench):
    reading = read_tree_text(EXPLICIT, bench.registry)

    assert reading.tree is not None and not reading.errors
    assert any("<AlwaysSuccess .../>" in str(warning) for warning in reading.warnings)


def test_an_exception_while_the_tree_is_halted_ends_the_run():
    body = '<Sequence _onHalted="nope = 1"><Scripted name="a" outcomes="R"/></Sequence>'
    trace = {
        "ticks": [
            {"root": "RUNNING", "events": [{"node": "a", "ev": "start", "outcome": "R"}]},
            {"op": "haltTree", "error": "it raised", "events": [{"node": "a", "ev": "halt"}]},
        ]
    }

    assert compare(document(body, "halt_before=2; ticks=3"), trace) == []


@pytest.mark.parametrize("comment", ["<!-->", "<!--->"])
def test_a_comment_does_not_end_within_its_opening(comment):
    assert compare(document("<AlwaysSuccess/>", others=comment), REJECTED) == []


def test_the_same_name_shorthand_in_a_model_means_the_name_and_is_warned_of(bench):
    model = '<TreeNodesModel><SubTree ID="T"><input_port name="h" default="{=}"/></SubTree>'
    text = document('<SubTree ID="T" name="t"/>', others=SUBTREE + model + "</TreeNodesModel>")

    reading = read_tree_text(text, bench.registry)

    assert reading.tree.scopes["t"].remapped == {"h": "h"}
    assert any("write {h}" in str(warning) for warning in reading.warnings)


def test_a_tree_inside_a_tree_that_nothing_uses_is_not_found_by_the_engine():
    inside = '<BehaviorTree ID="U"><Inverter><BehaviorTree ID="V"><AlwaysSuccess/></BehaviorTree>'
    text = document("<AlwaysSuccess/>", others=inside + "</Inverter></BehaviorTree>")

    assert compare(text, once("SUCCESS")) == []


def test_a_tree_inside_a_tree_is_an_error_for_users_whether_it_is_used_or_not(bench):
    inside = '<BehaviorTree ID="V"><AlwaysSuccess/></BehaviorTree>'
    unused = f'<BehaviorTree ID="U">{inside}</BehaviorTree>'

    for text in (document(inside), document("<AlwaysSuccess/>", others=unused)):
        errors = read_tree_text(text, bench.registry).errors
        assert ["cannot stand inside another" in str(error) for error in errors] == [True]


def test_an_explicit_element_with_the_id_subtree_names_a_tree():
    assert compare(document('<Action ID="SubTree"/>'), REJECTED) == []


@pytest.mark.parametrize(("levels", "accepted"), [(496, True), (497, False)])
def test_elements_nest_as_deep_as_in_the_engine(levels, accepted):
    model = f"<TreeNodesModel>{'<a>' * levels}{'</a>' * levels}</TreeNodesModel>"
    text = document("<AlwaysSuccess/>", others=model)

    assert compare(text, once("SUCCESS") if accepted else REJECTED) == []


@pytest.mark.parametrize(("value", "written"), [("true", 1), ("false", None)])
def test_an_integer_entry_takes_the_truth_value_true_only(value, written):
    body = (
        '<Sequence><SetOutInt name="a" value="5" out="{@z}"/>'
        f'<SetOutBool name="b" value="{value}" out="{{@z}}"/></Sequence>'
    )
    events = [{"node": "a", "ev": "tick", "wrote": 5}]
    if written is not None:
        events.append({"node": "b", "ev": "tick", "wrote": written})
    text = document(
        '<SubTree ID="T" name="t"/>', "bb.string.z=s", f'<BehaviorTree ID="T">{body}</BehaviorTree>'
    )

    trace = once(None if written is None else "SUCCESS", *events, Main={"z": written or 5}, t={})

    assert compare(text, trace) == []


def test_of_two_ports_with_one_key_the_last_one_declares_the_entry():
    body = '<LoopDouble queue="{u}" value="{u}"><SetOutInt value="1" out="{u}"/></LoopDouble>'

    assert compare(document(body), REJECTED) == []


def test_a_script_cannot_create_a_root_key_through_a_remap():
    inner = '<BehaviorTree ID="S"><Script code="x := 2"/></BehaviorTree>'
    text = document('<SubTree ID="S" name="t" x="{@x}"/>', others=inner)

    trace = once(None)
    trace.pop("final_blackboard")

    assert compare(text, trace) == []


def test_a_loop_over_a_root_key_that_does_not_exist_is_empty():
    loop = '<LoopInt queue="{y}" if_empty="FAILURE"><AlwaysSuccess/></LoopInt>'
    inner = f'<BehaviorTree ID="S">{loop}</BehaviorTree>'
    text = document('<SubTree ID="S" name="t" y="{@y}"/>', others=inner)

    trace = once("FAILURE")
    trace.pop("final_blackboard")

    assert compare(text, trace) == []


def test_set_blackboard_takes_any_number_of_signs_of_the_root():
    text = document('<SetBlackboard value="7" output_key="@@x"/>')

    assert compare(text, once("SUCCESS", Main={"x": "7"})) == []
