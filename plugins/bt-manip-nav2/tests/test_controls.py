"""The control nodes give the statuses of Nav2's unit tests (nav2_behavior_tree/test/plugins)."""

import functools

import pytest

from bt_manip.bt import BehaviourRegistry, NodeStatus, Tree, parse_tree
from bt_manip.exceptions import BtManipError, NodeError
from bt_manip_nav2.controls import (
    NonblockingSequence,
    PersistentSequence,
    PipelineSequence,
    RecoveryNode,
    RoundRobin,
)

from .dummy import Dummy

IDLE, RUNNING, SUCCESS = NodeStatus.IDLE, NodeStatus.RUNNING, NodeStatus.SUCCESS
FAILURE, SKIPPED = NodeStatus.FAILURE, NodeStatus.SKIPPED


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


ALL_IDLE = [IDLE, IDLE, IDLE]
WRAPPED = functools.partial(RoundRobin, wrap_around=True)


class Counting(Dummy):
    """Change to another status at its second tick, like the dummy of the tests of RecoveryNode."""

    ticks = 0
    later = None

    def _tick(self):
        self.ticks += 1
        return self.later if self.later is not None and self.ticks == 2 else self.result


@pytest.fixture
def recovery():
    rig = Rig(RecoveryNode, 2, number_of_retries=1)
    return rig


def retrying(later):
    main, second = Counting("main"), Dummy("recovery")
    main.result, main.later, second.result = FAILURE, later, SUCCESS
    node = RecoveryNode(main, second, number_of_retries=1)
    Tree(node)
    return node, main, second


def test_recovery_node_takes_two_children():
    with pytest.raises(BtManipError, match="must have 2 children; it has 3"):
        Rig(RecoveryNode, 3)


def test_recovery_node_runs_while_one_of_its_children_does(recovery):
    assert recovery.tick(RUNNING, IDLE) is RUNNING
    assert recovery.tick(FAILURE, RUNNING) is RUNNING


def test_recovery_node_refuses_idle_children(recovery):
    with pytest.raises(NodeError, match="IDLE"):
        recovery.tick(IDLE, IDLE)
    with pytest.raises(NodeError, match="IDLE"):
        recovery.tick(FAILURE, IDLE)


def test_recovery_node_succeeds_at_once_or_after_a_recovery(recovery):
    assert recovery.tick(SUCCESS, IDLE) is SUCCESS
    node, main, second = retrying(SUCCESS)
    assert node.execute() is SUCCESS
    assert (node.engine_status, main.engine_status, second.engine_status) == (SUCCESS, IDLE, IDLE)
    assert main.ticks == 2


def test_recovery_node_fails_with_its_recovery_or_after_it(recovery):
    assert recovery.tick(FAILURE, FAILURE) is FAILURE
    assert recovery.statuses == [IDLE, IDLE]
    node, main, second = retrying(FAILURE)
    assert node.execute() is FAILURE
    assert (node.engine_status, main.engine_status, second.engine_status) == (FAILURE, IDLE, IDLE)
    assert main.ticks == 2


def test_recovery_node_is_skipped_with_its_first_child_and_fails_without_a_recovery(recovery):
    assert recovery.tick(SKIPPED, SUCCESS) is SKIPPED
    assert recovery.node.engine_status is IDLE
    assert recovery.statuses == [IDLE, IDLE]
    assert recovery.tick(FAILURE, SKIPPED) is FAILURE
    assert recovery.node.engine_status is FAILURE
    assert recovery.statuses == [IDLE, IDLE]


@pytest.mark.parametrize("cls", [PipelineSequence, RoundRobin, NonblockingSequence])
def test_an_idle_child_is_an_error(cls):
    with pytest.raises(NodeError, match="IDLE"):
        Rig(cls).tick(*ALL_IDLE)


LETTERS = {"I": IDLE, "R": RUNNING, "S": SUCCESS, "F": FAILURE, "K": SKIPPED}
ROUNDS = {
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
    rig = Rig(cls)
    for one in rounds.split():
        if one == "|":
            rig.node.halt()
            continue
        children, _, result = one.partition("-")
        assert rig.tick(*(LETTERS[letter] for letter in children)) is LETTERS[result], one
        assert result == "R" or "I" in children or rig.statuses == ALL_IDLE
    assert rig.statuses == ALL_IDLE


def test_nonblocking_sequence_refuses_a_skipped_child():
    with pytest.raises(NodeError, match="skipped"):
        Rig(NonblockingSequence).tick(SUCCESS, SKIPPED, SUCCESS)


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
