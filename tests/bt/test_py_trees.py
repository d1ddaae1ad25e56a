"""Nodes of ours and stock py_trees behaviours, mixed both ways."""

import py_trees
import pytest
from py_trees.common import Status

from bt_manip.bt import (
    AlwaysFailure,
    AlwaysSuccess,
    Fallback,
    Inverter,
    NodeStatus,
    Parallel,
    ReactiveSequence,
    Sequence,
    Tree,
)
from bt_manip.exceptions import NodeError


class Stock(py_trees.behaviour.Behaviour):
    """A stock behaviour that returns statuses from a list, and keeps a diary."""

    def __init__(self, name, statuses):
        super().__init__(name)
        self.statuses = list(statuses)
        self.diary = []

    def initialise(self):
        self.diary.append("initialise")

    def update(self):
        self.diary.append("update")
        return {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING}[
            self.statuses.pop(0) if len(self.statuses) > 1 else self.statuses[0]
        ]

    def terminate(self, new_status):
        self.diary.append(new_status.name)


class TestStockChildren:
    """Stock behaviours under our nodes."""

    def test_they_live_as_they_do_under_stock_parents(self):
        stock = Stock("stock", "RS")
        tree = Tree(Sequence(AlwaysSuccess(), stock))

        assert [tree.tick().name for _ in range(2)] == ["RUNNING", "SUCCESS"]
        assert stock.diary == ["initialise", "update", "update", "SUCCESS"]

    def test_they_are_stopped_when_they_are_halted(self):
        stock = Stock("stock", "R")
        tree = Tree(Sequence(stock))
        tree.tick()
        tree.halt()

        assert stock.diary == ["initialise", "update", "INVALID"]
        assert stock.status is Status.INVALID

    def test_a_reactive_parent_halts_them(self):
        stock = Stock("stock", "R")
        tree = Tree(ReactiveSequence(Inverter(Stock("c", "FRR")), stock))
        tree.tick()
        tree.tick()

        assert stock.diary[-1] == "INVALID"

    def test_they_count_among_the_nodes_of_the_tree(self):
        inner = py_trees.composites.Sequence("inner", True, [AlwaysSuccess("ours")])
        tree = Tree(Fallback("top", [inner]))

        assert [node.name for node in tree.nodes] == ["top", "inner", "ours"]
        assert tree.tick() is NodeStatus.SUCCESS
        assert len(tree.statuses()) == 3

    def test_an_exception_in_them_names_them(self):
        stock = Stock("stock", "S")
        stock.update = lambda: 1 / 0

        with pytest.raises(NodeError, match=r"^stock \[Stock\]: division by zero"):
            Tree(Sequence(stock)).tick()

    def test_their_feedback_is_the_reason_of_a_failure(self):
        stock = Stock("stock", "F")
        stock.feedback_message = "out of luck"
        tree = Tree(Sequence(stock))
        tree.tick()

        assert tree.failure_reason() == "stock: out of luck"


class TestStockParents:
    """Our nodes under stock composites, decorators and trees."""

    def test_a_stock_root_runs_in_our_tree(self):
        root = py_trees.composites.Sequence("root", True, [AlwaysSuccess(), AlwaysSuccess()])
        tree = Tree(root)

        assert [tree.tick() for _ in range(2)] == [NodeStatus.SUCCESS] * 2

    def test_the_statuses_of_stock_nodes_are_known_wherever_they_stand(self):
        inner = py_trees.composites.Sequence("inner", True, [Stock("leaf", "R")])
        tree = Tree(py_trees.composites.Selector("root", True, [AlwaysFailure(), inner]))
        tree.tick()

        assert list(tree.statuses()) == [1, 3, 1, 1]

    def test_our_nodes_run_in_a_stock_tree(self):
        stock = Stock("stock", "RS")
        root = py_trees.composites.Selector(
            "root", True, [AlwaysFailure(), Sequence("ours", [stock, AlwaysSuccess()])]
        )
        tree = py_trees.trees.BehaviourTree(root)
        tree.tick()
        assert root.status is Status.RUNNING
        tree.tick()
        assert root.status is Status.SUCCESS

    def test_a_completed_node_starts_anew_in_the_next_round(self):
        stock = Stock("stock", "S")
        tree = py_trees.trees.BehaviourTree(Sequence("ours", [stock]))
        tree.tick()
        tree.tick()

        assert stock.diary == ["initialise", "update", "SUCCESS"] * 2

    def test_a_stock_parent_stops_our_running_nodes(self):
        stock = Stock("stock", "R")
        ours = Sequence("ours", [stock])
        root = py_trees.composites.Selector("root", False, [Stock("first", "FSS"), ours])
        tree = py_trees.trees.BehaviourTree(root)
        tree.tick()
        assert ours.engine_status is NodeStatus.RUNNING
        tree.tick()

        assert stock.diary[-1] == "INVALID"
        assert ours.engine_status is NodeStatus.IDLE and ours.status is Status.INVALID

    def test_a_stock_decorator_takes_our_node(self):
        root = py_trees.decorators.Inverter("not", Sequence(AlwaysFailure()))
        root.tick_once()

        assert root.status is Status.SUCCESS

    def test_a_visitor_sees_every_node_that_was_ticked(self):
        root = Sequence(
            "top", [AlwaysSuccess("a"), py_trees.behaviours.Running("b"), AlwaysSuccess("c")]
        )
        tree = py_trees.trees.BehaviourTree(root)
        visitor = py_trees.visitors.SnapshotVisitor()
        tree.add_visitor(visitor)
        tree.tick()

        names = {node.name: visitor.visited.get(node.id) for node in root.iterate()}
        assert names == {
            "a": Status.SUCCESS,
            "b": Status.RUNNING,
            "c": None,
            "top": Status.RUNNING,
        }

    def test_a_visitor_sees_children_before_their_parents_also_below_stock_nodes(self):
        inner = py_trees.composites.Sequence("inner", True, [AlwaysSuccess("x")])
        root = Sequence("top", [inner, AlwaysSuccess("y")])
        seen = [node.name for node in root.tick()]

        assert seen == ["x", "inner", "y", "top"]


class TestDisplays:
    """Our nodes show in py_trees' displays."""

    @pytest.fixture
    def root(self):
        root = Sequence(
            "top", [AlwaysSuccess("a"), Parallel("p", [Inverter("n", AlwaysFailure("f"))])]
        )
        Tree(root).tick()
        return root

    def test_as_text(self, root):
        text = py_trees.display.ascii_tree(root, show_status=True)

        assert [line.split()[1] for line in text.strip().splitlines()] == [
            "top",
            "a",
            "p",
            "n",
            "f",
        ]
        assert "[o]" in text

    def test_as_xhtml_and_dot(self, root):
        assert "top" in py_trees.display.xhtml_tree(root)
        graph = py_trees.display.dot_tree(root)
        assert {node.get_name().strip('"') for node in graph.get_nodes()} >= {"top", "a", "p", "n"}

    def test_the_tip_is_the_node_that_decided(self, root):
        assert root.tip().name in ("f", "n", "a")
        running = py_trees.behaviours.Running("r")
        tree = Tree(Sequence("s", [AlwaysSuccess(), running]))
        tree.tick()
        assert tree.root.tip() is running


def test_children_change_by_py_trees_own_methods():
    top = Sequence("top")
    top.add_child(AlwaysSuccess("a"))
    top.add_children([AlwaysFailure("b")])
    top.prepend_child(AlwaysSuccess("first"))
    tree = py_trees.trees.BehaviourTree(top)
    tree.tick()
    assert top.status is Status.FAILURE
    top.remove_child(top.children[2])
    tree.tick()
    assert top.status is Status.SUCCESS
    top.replace_child(top.children[0], AlwaysFailure("new"))
    tree.tick()
    assert top.status is Status.FAILURE
    top.remove_all_children()
    assert top.children == []


def test_a_yielding_node_runs_on_with_the_next_tick_of_a_stock_tree():
    from bt_manip.bt import AsyncSequence

    tree = py_trees.trees.BehaviourTree(AsyncSequence(AlwaysSuccess("a"), AlwaysSuccess("b")))
    tree.tick()
    assert tree.root.status is Status.RUNNING
    tree.tick()
    assert tree.root.status is Status.SUCCESS
