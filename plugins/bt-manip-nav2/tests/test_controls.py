"""The control nodes give the statuses of Nav2's unit tests (nav2_behavior_tree/test/plugins)."""

import functools

import pytest

from bt_manip.bt import BehaviourRegistry, Tree, parse_tree
from bt_manip.exceptions import BtManipError, NodeError
from bt_manip_nav2.controls import (
    NonblockingSequence,
    PersistentSequence,
    PipelineSequence,
    RecoveryNode,
    RoundRobin,
)

from .dummy import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Dummy


class Rig:
    """A node with dummies, ticked as Nav2's tests tick it: without a reset between two ticks."""

    def __init__(self, cls, count=3, **ports):
        self.children = [Dummy(f"child {number}") for number in range(count)]
        self.node = cls(*self.children, **ports)
        self.tree = Tree(self.node)

    def tick(self, *results):
        for child, result in zip(self.children, results, strict=True):
            child.result = result
        return self.node.execute()

    @property
    def statuses(self):
        return [child.engine_status for child in self.children]


RECOVERY = functools.partial(RecoveryNode, number_of_retries=1)
WRAPPED = functools.partial(RoundRobin, wrap_around=True)


@pytest.fixture
def recovery():
    return Rig(RECOVERY, 2)


def test_recovery_node_takes_two_children():
    with pytest.raises(BtManipError, match="must have 2 children; it has 3"):
        Rig(RecoveryNode, 3)


@pytest.mark.parametrize("result", [SUCCESS, FAILURE])
def test_recovery_node_ends_with_the_result_after_its_recovery(recovery, result):
    results = iter([FAILURE, result])
    assert recovery.tick(results, SUCCESS) is recovery.node.engine_status is result
    assert recovery.statuses == [IDLE, IDLE] and not [*results]


LETTERS = {"I": IDLE, "R": RUNNING, "S": SUCCESS, "F": FAILURE, "K": SKIPPED}
ROUNDS = {
    "a recovery node runs while one of its children does": (RECOVERY, "RI-R FR-R FF-F"),
    "a recovery node succeeds at once": (RECOVERY, "SI-S"),
    "a recovery node is skipped with its first child and fails without a recovery": (
        RECOVERY,
        "KS-K FK-F",
    ),
    "a pipeline ends and resets all with a child that fails": (
        PipelineSequence,
        "FII-F SFI-F SSF-F SSR-R FSR-F",
    ),
    "a nonblocking sequence ends and resets all with a child that fails": (
        NonblockingSequence,
        "FII-F SFI-F SSF-F SSR-R FSR-F",
    ),
    "a pipeline goes past a running child once it has been further": (
        PipelineSequence,
        "RII-R SRI-R RSR-R RSS-S",
    ),
    "a pipeline passes over skipped children": (PipelineSequence, "KSS-S KSF-F KKK-K"),
    "round robin fails once all children have failed": (WRAPPED, "FRI-R FFR-R FFF-F"),
    "round robin goes on after the child that succeeded": (
        WRAPPED,
        "RII-R FRI-R FSI-S IIR-R RIF-R FSF-S",
    ),
    "round robin passes over skipped children": (WRAPPED, "KSF-S KKF-F KKK-K"),
    "round robin without wrap_around ends with the last child": (
        RoundRobin,
        "FFF-F | KKK-K FSI-S FFF-F SFF-S",  # at the second FFF, only the third was left
    ),
    "a nonblocking sequence ticks all until all succeed together": (
        NonblockingSequence,
        "RSR-R SSR-R RSS-R SSS-S RRF-F",
    ),
}


@pytest.mark.parametrize(("cls", "rounds"), ROUNDS.values(), ids=ROUNDS)
def test_children_decide_the_result(cls, rounds):
    rig = Rig(cls, rounds.index("-"))
    for one in rounds.split():
        if one == "|":
            rig.node.halt()
            continue
        children, _, result = one.partition("-")
        assert rig.tick(*(LETTERS[letter] for letter in children)) is LETTERS[result], one
        assert result == "R" or "I" in children or set(rig.statuses) == {IDLE}
    assert set(rig.statuses) == {IDLE}


@pytest.mark.parametrize(
    ("cls", "children", "status"),
    [
        (RECOVERY, "II", "IDLE"),
        (RECOVERY, "FI", "IDLE"),
        (PipelineSequence, "III", "IDLE"),
        (RoundRobin, "III", "IDLE"),
        (NonblockingSequence, "III", "IDLE"),
        (NonblockingSequence, "SKS", "skipped"),
    ],
)
def test_a_status_that_a_child_must_not_have_is_an_error(cls, children, status):
    with pytest.raises(NodeError, match=status):
        Rig(cls, len(children)).tick(*(LETTERS[letter] for letter in children))


PERSISTENT = """<root BTCPP_format="4"><BehaviorTree ID="Main">
  <PersistentSequence {port}><AlwaysSuccess/></PersistentSequence></BehaviorTree></root>"""


def test_persistent_sequence_needs_its_entry():
    registry = BehaviourRegistry([PersistentSequence])
    with pytest.raises(BtManipError, match="current_child_idx"):
        parse_tree(PERSISTENT.format(port=""), registry, main="Main")
    tree = parse_tree(
        PERSISTENT.format(port='current_child_idx="{i}"'), registry, main="Main", strict=False
    )
    with pytest.raises(NodeError, match="'i' was never written"):
        tree.tick()
    tree.blackboard["i"] = 0
    assert tree.root.execute() is SUCCESS


def test_persistent_sequence_keeps_its_index_in_an_entry():
    rig = Rig(PersistentSequence, current_child_idx="{i}")
    entries = rig.tree.blackboard
    entries["i"] = 0
    assert (rig.tick(RUNNING, RUNNING, RUNNING), entries["i"]) == (RUNNING, 0)
    assert (rig.tick(SUCCESS, RUNNING, RUNNING), entries["i"]) == (RUNNING, 1)
    assert (rig.tick(SUCCESS, FAILURE, RUNNING), entries["i"]) == (FAILURE, 0)
    entries["i"] = 1
    assert (rig.tick(FAILURE, SKIPPED, RUNNING), entries["i"]) == (RUNNING, 2)
    assert (rig.tick(FAILURE, SKIPPED, SUCCESS), entries["i"]) == (SUCCESS, 0)


def test_halt_begins_the_retries_anew(recovery):
    assert recovery.tick(FAILURE, RUNNING) is RUNNING
    recovery.node.halt()
    assert recovery.node.get_state() == {"_index": 0, "_retries": 0}
    assert recovery.tick(RUNNING, IDLE) is RUNNING
