"""What no run of a tree can do is found before it runs, at its line; what some run can do is not.

The statuses that nodes can have are compared with the engine's traces beside this.
"""

import inspect

import pytest

from bt_manip import behaviours
from bt_manip.bt import Action, BehaviourRegistry, NodeStatus, SyncAction, Traits
from bt_manip.bt.loading import read_tree_text
from bt_manip.bt.nodes import Node
from bt_manip.exceptions import NodeError, TreeError


class Work(Action):
    traits = Traits()

    def update(self):
        return NodeStatus.SUCCESS


class Anything(Action):
    def update(self):
        return NodeStatus.SUCCESS


class Answer(SyncAction):
    traits = Traits(returns={NodeStatus.SUCCESS, NodeStatus.FAILURE})

    def update(self):
        return NodeStatus.FAILURE


@pytest.fixture(scope="module")
def registry():
    registry = BehaviourRegistry()
    for cls in (Work, Anything, Answer, *vars(behaviours).values()):
        if inspect.isclass(cls) and issubclass(cls, Node):
            registry.register(cls)
    return registry


def warnings(registry, body, rest="", head=""):
    text = (
        '<root BTCPP_format="4" main_tree_to_execute="Main">\n'
        f'<BehaviorTree ID="Main" {head}>\n{body}\n</BehaviorTree>{rest}\n</root>'
    )
    reading = read_tree_text(text, registry)
    assert reading.errors == ()
    return [f"{one.place.line}: {one.message}" for one in reading.warnings]


PICK = """<SpawnObject object="{c}"/>
<OpenGripper/>
<Hover object="{c}"/>
<Reach object="{c}"/>
<Grasp object="{c}"/>
<Lift/>"""


def sequence(*lines):
    return "<Sequence>\n" + "\n".join(lines) + "\n</Sequence>"


WRONG = {
    "after what always succeeds": (
        "<Fallback>\n<Work/>\n<AlwaysSuccess/>\n<Answer/>\n</Fallback>",
        "6: Answer never runs: 'AlwaysSuccess' before it always succeeds",
    ),
    "after what always fails": (
        sequence("<Inverter><AlwaysSuccess/></Inverter>", "<Work/>"),
        "5: Work never runs: 'Inverter' before it always fails",
    ),
    "a branch that is never chosen": (
        "<IfThenElse>\n<AlwaysSuccess/>\n<Work/>\n<Answer/>\n</IfThenElse>",
        "6: Answer never runs: the condition 'AlwaysSuccess' never fails",
    ),
    "a clean-up after what cannot fail": (
        "<TryCatch>\n<AlwaysSuccess/>\n<Work/>\n</TryCatch>",
        "5: Work never runs: no child before it can fail",
    ),
    "a guard that always holds": (
        sequence('<Work _failureIf="1 &gt; 0"/>'),
        "4: Work never runs: its _failureIf always holds",
    ),
    "a guard that never holds": (
        '<Work _while="1 == 2"/>',
        "3: Work never runs: its _while never holds",
    ),
    "an endless retry": (
        '<RetryUntilSuccessful num_attempts="-1">\n<Sequence>\n<AlwaysSuccess/>\n<AlwaysFailure/>\n'
        "</Sequence>\n</RetryUntilSuccessful>",
        "3: RetryUntilSuccessful never ends: 'Sequence' fails at once",
    ),
    "an endless repetition": (
        '<Repeat num_cycles="-1"><Script code="n := 1" /></Repeat>\n',
        "3: Repeat never ends: 'Script' succeeds at once",
    ),
    "no rounds": (
        '<Repeat num_cycles="0">\n<Work/></Repeat>',
        "4: Work never runs: num_cycles is 0",
    ),
    "a timeout below the sum of what it waits for": (
        '<Timeout msec="500">\n'
        + sequence('<Sleep msec="300"/>', '<Delay delay_msec="300"><Answer/></Delay>')
        + "</Timeout>",
        "3: Timeout always ends 'Sequence', which takes at least 600 ms, after 500 ms",
    ),
    "a number of successes out of reach": (
        '<Parallel success_count="2" failure_count="2">\n<Work/>\n<AlwaysFailure/>\n</Parallel>',
        "3: Parallel never succeeds: too few can, 'AlwaysFailure' always fails",
    ),
    "a case twice": (
        '<Switch2 variable="{v}" case_1="1" case_2="1.0"><Work/><Work/><Work/></Switch2>',
        "3: case_2 repeats case_1",
    ),
    "a gripper twice in a ReactiveSequence": (
        "<ReactiveSequence>\n<OpenGripper/>\n<CloseGripper/>\n</ReactiveSequence>",
        "5: CloseGripper commands the gripper that OpenGripper at <text>:4:1",
    ),
    "an arm twice, the second on one of two branches": (
        "<Parallel>\n<MoveHome/>\n<IfThenElse>\n<Answer/>\n<Lift/>\n<OpenGripper/>\n"
        "</IfThenElse></Parallel>",
        "7: Lift commands the arm that MoveHome at <text>:4:1 commands at the same time",
    ),
    "after what ends only by failing": (
        sequence("<KeepRunningUntilFailure><Work/></KeepRunningUntilFailure>", "<Lift/>"),
        "5: Lift never runs: 'KeepRunningUntilFailure' before it always fails",
    ),
    "a precondition that never holds": (
        '<Precondition if="1 == 2">\n<Work/></Precondition>',
        "4: Work never runs: the condition above it never holds",
    ),
    "a Switch over a text": (
        '<Switch2 variable="kind" case_1="1" case_2="2"><Work/><Work/><Work/></Switch2>',
        "3: the variable is the text 'kind', so that the same child always runs; {kind} reads",
    ),
    "a timeout by an entry": (
        sequence('<Script code="t := 100"/>', '<Timeout msec="{t}"><Sleep msec="500"/></Timeout>'),
        "5: Timeout always ends 'Sleep'",
    ),
    "a count that begins nowhere": (
        sequence('<Script code="n += 1"/>', '<ScriptCondition code="n == 1"/>'),
        "4: this script always fails: error in script [n += 1]: the blackboard entry 'n' does not",
    ),
    "a speed in percent": ('<Lift speed="50"/>', "3: speed holds '50': must be"),
    "a text for a number": (
        sequence("<Script code=\"h := 'high'\"/>", '<Lift height="{h}"/>'),
        "4: this script always fails: error in script [h := 'high']: entry 'h' does not take",
    ),
    "a number out of its bounds": (
        sequence('<Script code="v := 2"/>', '<Lift speed="{v}"/>'),
        "5: the entry 'v' holds 2: must be",
    ),
    "written and not read": (
        sequence(
            "<Script code=\"goal := 'home'\"/>", '<MoveToConfiguration configuration="{gaol}"/>'
        ),
        "4: nothing reads the blackboard entry 'goal' that is written here; did you mean 'gaol'?",
    ),
    "15 metres": (
        sequence(PICK.replace("<Lift/>", '<Lift height="15"/>')),
        "9: height is 15 metres",
    ),
    "a decimal comma": (
        '<SetSpeed speed="0,5"/>',
        "3: speed is 0: the ',5' after it is ignored; did you mean 0.5?",
    ),
    "a number with another unit": (
        '<Sleep msec="2s"/>',
        "3: msec is 2: the 's' after it is ignored",
    ),
    "90 radians": (
        '<MoveToPose pose="0;0;1" cone="90"/>'.replace("0;0;1", "0.5;0;0.5;0;1;0;0"),
        "3: cone is 90 radians, which is beyond any cell; is it meant in degrees?",
    ),
    "grasp with nothing reached": (
        sequence(PICK.replace('<Reach object="{c}"/>\n', "")),
        "7: Grasp: nothing has moved the tool to an object",
    ),
    "drop with nothing held": (
        sequence("<OpenGripper/>", '<Drop container="basket"/>'),
        "5: Drop: the gripper holds nothing here",
    ),
    "reach with a closed gripper": (
        sequence("<CloseGripper/>", '<Reach object="cube"/>'),
        "5: Reach: the gripper is closed here",
    ),
    "an endless retry of a condition, which stands while the tick lasts": (
        '<RetryUntilSuccessful num_attempts="-1"><IsHolding object="a"/></RetryUntilSuccessful>',
        "3: RetryUntilSuccessful never ends once 'IsHolding' fails: nothing changes within one",
    ),
    "a success that comes after the timeout": (
        '<Timeout msec="100">\n' + sequence("<Work/>", '<Sleep msec="200"/>') + "</Timeout>",
        "3: Timeout ends 'Sequence', whose success takes at least 200 ms, after 100 ms",
    ),
    "read before it is written, in each round": (
        '<RetryUntilSuccessful num_attempts="3">\n'
        + sequence('<Hover object="{c}"/>', '<SpawnObject object="{c}"/>')
        + "</RetryUntilSuccessful>",
        "5: the entry 'c' is read here before SpawnObject at <text>:6:22 writes it",
    ),
    "read by the guard of the node that writes it": (
        '<Repeat num_cycles="3"><Work _skipIf="done" _onSuccess="done := true"/></Repeat>',
        "3: the entry 'done' is read here before Work",
    ),
    "a text as a condition": (
        sequence("<Script code=\"ready := 'yes'\"/>", '<Work _skipIf="ready"/>'),
        "5: this script always fails: 'yes' is neither true nor false",
    ),
    "the name of an entry in an entry that nothing writes": (
        '<SetBlackboard value="0.2" output_key="{h}"/>',
        "3: nothing writes the blackboard entry 'h' that is read here",
    ),
    "a wait for an entry that nothing writes": (
        '<WaitValueUpdate entry="{pose}"><Work/></WaitValueUpdate>',
        "3: nothing writes the blackboard entry 'pose' that is read here",
    ),
    "grasp of a new object": (
        sequence('<SpawnObject object="{c}"/>', "<OpenGripper/>", '<Grasp object="{c}"/>'),
        "6: Grasp: nothing has moved the tool to an object",
    ),
}


@pytest.mark.parametrize(("body", "finding"), WRONG.values(), ids=WRONG)
def test_what_no_run_can_do_is_found_at_its_line(registry, body, finding):
    found = warnings(registry, body)
    assert any(one.startswith(finding) for one in found), found


RIGHT = {
    "a number with the unit of its port": '<BackOff distance="0.1 m"/>',
    "a whole number with decimals": (
        '<RetryUntilSuccessful num_attempts="3.0"><Anything/></RetryUntilSuccessful>'
    ),
    "a gripper that was never opened": sequence(
        '<Hover object="cube"/>', '<Reach object="cube"/>', '<Grasp object="cube"/>'
    ),
    "something unknown before a grasp": sequence(
        '<Hover object="cube"/>', "<Anything/>", '<Grasp object="cube"/>'
    ),
    "a retry that enters again after the drop": (
        '<RetryUntilSuccessful num_attempts="3">'
        + sequence(
            '<Fallback><IsHolding object="cube"/>'
            + sequence(PICK.replace("{c}", "cube"))
            + "</Fallback>",
            '<Drop container="basket"/>',
        )
        + "</RetryUntilSuccessful>"
    ),
    "a clean-up that reads what may be there": (
        "<TryCatch>"
        + sequence(PICK)
        + '<Fallback><RemoveObject object="{c}"/></Fallback></TryCatch>'
    ),
    "an entry that the other child of a Parallel writes": (
        '<Parallel><Hover object="{c}"/><SpawnObject object="{c}"/></Parallel>'
    ),
    "an arm and its gripper": "<Parallel><MoveHome/><OpenGripper/></Parallel>",
    "an arm that moves under exclusive conditions": (
        '<Parallel failure_count="2">'
        + sequence("<Answer/>", "<Lift/>")
        + sequence("<Inverter><Answer/></Inverter>", "<MoveHome/>")
        + "</Parallel>"
    ),
    "an arm that moves on one branch, while the other work takes time before": (
        "<Parallel><MoveHome/><IfThenElse><Work/><Lift/><AlwaysFailure/></IfThenElse></Parallel>"
    ),
    "a precondition on an entry": sequence(
        '<Script code="a := 1"/>', '<Precondition if="a == 1"><Work/></Precondition>'
    ),
    "a count that begins before, in a script": sequence(
        '<Script code="n := 0; n += 1"/>', '<ScriptCondition code="n == 1"/>'
    ),
    "a retry after what ends only by failing": (
        "<Fallback><KeepRunningUntilFailure><Work/></KeepRunningUntilFailure><Lift/></Fallback>"
    ),
    "an endless loop that takes time": '<Repeat num_cycles="-1"><Sleep msec="10"/></Repeat>',
    "an endless retry of what may succeed": (
        '<RetryUntilSuccessful num_attempts="-1"><Answer/></RetryUntilSuccessful>'
    ),
    "a timeout around what has no end": (
        '<Timeout msec="100"><KeepRunningUntilFailure><Work/></KeepRunningUntilFailure></Timeout>'
    ),
    "a number in a text": sequence("<Script code=\"h := '0.1'\"/>", '<Lift height="{h}"/>'),
    "an endless loop under a condition that it changes": sequence(
        '<Script code="n := 0"/>',
        '<Repeat num_cycles="-1" _while="n &lt; 5"><Script code="n += 1"/></Repeat>',
        '<ReactiveSequence><ScriptCondition code="n &lt; 9"/><Repeat num_cycles="-1">'
        '<Script code="n += 1"/></Repeat></ReactiveSequence>',
    ),
    "an endless retry of a condition that takes time": (
        '<RetryUntilSuccessful num_attempts="-1"><Delay delay_msec="50"><IsHolding object="a"/>'
        "</Delay></RetryUntilSuccessful>"
    ),
    "an entry that is named by an entry": sequence(
        "<Script code=\"name := 'h'\"/>",
        '<SetBlackboard value="0.2" output_key="{name}"/>',
        '<Lift height="{h}"/>',
    ),
    "an entry that a condition writes": sequence(
        '<ScriptCondition code="h := 0.2; h &gt; 0.1"/>', '<Lift height="{h}"/>'
    ),
    "read only in the second round, which follows the writing": sequence(
        '<Script code="first := true"/>',
        '<Repeat num_cycles="2"><Sequence><Lift height="{h}" _skipIf="first"/>'
        '<Script code="h := 0.2; first = false"/></Sequence></Repeat>',
    ),
    "a drop that fails in the first round, without an object": sequence(
        '<SpawnObject object="{c}"/>',
        '<RetryUntilSuccessful num_attempts="2"><Fallback><Drop container="basket"/>'
        "<ForceFailure>" + sequence(PICK.split("\n", 1)[1]) + "</ForceFailure></Fallback>"
        "</RetryUntilSuccessful>",
    ),
    "two arms of sub-trees": (
        '<Parallel><SubTree ID="Up" robot="left"/>'
        '<SubTree ID="Up" name="b" robot="right"/></Parallel>',
        '<BehaviorTree ID="Up"><Lift/></BehaviorTree>',
    ),
    "no rounds, as an option of a sub-tree": (
        '<SubTree ID="Again" rounds="0"/>',
        '<BehaviorTree ID="Again"><Repeat num_cycles="{rounds}"><Work/></Repeat></BehaviorTree>',
    ),
    "a robot by an entry": (
        sequence("<Script code=\"who := 'left'\"/>", '<SubTree ID="Up" robot="{who}"/>'),
        '<BehaviorTree ID="Up"><Lift/></BehaviorTree>',
    ),
    "a result of a sub-tree that one of two needs": (
        sequence(
            '<SubTree ID="Try" name="first" tries="{n}"/>',
            '<ScriptCondition code="n == 3"/>',
            '<SubTree ID="Try" name="second"/>',
        ),
        '<BehaviorTree ID="Try"><Script code="tries := 3"/></BehaviorTree>',
    ),
    "an attribute that is handed on under its own name": (
        '<SubTree ID="Outer" height="0.2"/>',
        '<BehaviorTree ID="Outer"><SubTree ID="Up" height="{=}"/></BehaviorTree>'
        '<BehaviorTree ID="Up"><Lift height="{height}"/></BehaviorTree>',
    ),
}


@pytest.mark.parametrize("bodies", RIGHT.values(), ids=RIGHT)
def test_what_some_run_can_do_is_no_finding(registry, bodies):
    assert warnings(registry, *([bodies] if isinstance(bodies, str) else bodies)) == []


def test_results_and_entries_that_are_given_are_no_findings(registry):
    body = sequence('<Script code="count := 1"/>', '<Hover object="{cube}"/>')
    model = (
        '<TreeNodesModel><SubTree ID="Main"><input_port name="cube"/></SubTree></TreeNodesModel>'
    )
    assert warnings(registry, body, model, '_results="count"') == []


def test_the_entry_of_the_task_and_what_another_cycle_left_are_no_findings(registry):
    body = sequence(
        "<Script code=\"said := 'drop it'\"/>",
        '<SpawnObject object="{c}"/>',
        '<Drop container="basket"/>',
    )
    assert warnings(registry, body, head='_task="{said}" _continues="true"') == []


def test_an_attribute_that_a_sub_tree_does_not_use_names_the_likely_one(registry):
    rest = '<BehaviorTree ID="Go"><Hover object="{object}"/></BehaviorTree>'
    found = warnings(registry, '<SubTree ID="Go" objet="cube"/>', rest=rest)
    assert found[0] == "3: the sub-tree 'Go' does not use 'objet'; did you mean 'object'?"


def test_an_endless_tick_fails_with_the_name_of_its_loop(bench, monkeypatch):
    monkeypatch.setattr("bt_manip.bt.tree.MAX_ROUNDS", 1000)
    tree = bench.tree(
        '<RetryUntilSuccessful name="again" num_attempts="-1">'
        "<AlwaysFailure/></RetryUntilSuccessful>"
    )
    said = r"again.*'AlwaysFailure' answered at once 1000 times"
    with pytest.raises(NodeError, match=said) as error:
        tree.tick()
    assert isinstance(error.value.__cause__, TreeError)  # of the author, no internal fault
