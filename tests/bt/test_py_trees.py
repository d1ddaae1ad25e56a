"""Nodes of ours and stock py_trees behaviours, mixed both ways."""

import py_trees
import pytest
from py_trees.common import Status

from bt_manip.bt import (
    AlwaysFailure,
    AlwaysSuccess,
    AsyncSequence,
    Inverter,
    NodeStatus,
    Parallel,
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

    def test_they_live_as_they_do_under_stock_parents_and_are_stopped_when_they_are_halted(self):
        stock = Stock("stock", "RSR")
        tree = Tree(Sequence(AlwaysSuccess(), stock))
        assert [tree.tick().name for _ in range(3)] == ["RUNNING", "SUCCESS", "RUNNING"]
        tree.halt()
        whole, halted = ["initialise", "update", "update", "SUCCESS"], ["initialise", "update"]
        assert stock.diary == [*whole, *halted, "INVALID"]
        assert stock.status is Status.INVALID

    def test_their_feedback_is_the_reason_of_a_failure_and_an_exception_names_them(self):
        stock = Stock("stock", "F")
        stock.feedback_message = "out of luck"
        tree = Tree(Sequence(stock))
        tree.tick()
        assert tree.failure_reason() == "stock: out of luck"

        stock.update = lambda: 1 / 0
        with pytest.raises(NodeError, match=r"^stock \[Stock\]: division by zero"):
            tree.tick()


class TestStockParents:
    """Our nodes under stock composites, decorators and trees."""

    def test_the_statuses_of_stock_nodes_are_known_wherever_they_stand(self):
        inner = py_trees.composites.Sequence("inner", True, [Stock("leaf", "R")])
        tree = Tree(py_trees.composites.Selector("root", True, [AlwaysFailure(), inner]))
        tree.tick()

        assert list(tree.statuses()) == [1, 3, 1, 1]

    def test_our_nodes_run_in_a_stock_tree_and_start_anew_in_the_next_round(self):
        stock = Stock("stock", "RS")
        root = py_trees.composites.Selector(
            "root", True, [AlwaysFailure(), Sequence("ours", [stock, AlwaysSuccess()])]
        )
        tree = py_trees.trees.BehaviourTree(root)
        for status in (Status.RUNNING, Status.SUCCESS, Status.SUCCESS):
            tree.tick()
            assert root.status is status
        assert stock.diary[-3:] == ["initialise", "update", "SUCCESS"]

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

    def test_a_visitor_sees_ticked_nodes_children_before_their_parents(self):
        inner = py_trees.composites.Sequence("inner", True, [AlwaysSuccess("x")])
        root = Sequence("top", [inner, py_trees.behaviours.Running("r"), AlwaysSuccess("y")])
        tree = py_trees.trees.BehaviourTree(root)
        visitor = py_trees.visitors.SnapshotVisitor()
        tree.add_visitor(visitor)
        tree.tick()

        names = {node.id: node.name for node in root.iterate()}
        assert {names[key]: status.name for key, status in visitor.visited.items()} == {
            "x": "SUCCESS", "inner": "SUCCESS", "r": "RUNNING", "top": "RUNNING",
        }  # fmt: skip
        root.stop(Status.INVALID)
        assert [node.name for node in root.tick()] == ["x", "inner", "r", "top"]


def test_py_trees_displays_show_our_nodes():
    running = py_trees.behaviours.Running("r")
    root = Sequence("top", [AlwaysSuccess("a"), Parallel("p", [Inverter("n", running)])])
    Tree(root).tick()
    text = py_trees.display.ascii_tree(root, show_status=True)

    assert [line.split()[1] for line in text.strip().splitlines()] == ["top", "a", "p", "n", "r"]
    assert "[o]" in text and "top" in py_trees.display.xhtml_tree(root)
    graph = py_trees.display.dot_tree(root)
    assert {node.get_name().strip('"') for node in graph.get_nodes()} >= {"top", "a", "p", "n"}
    assert root.tip() is running


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
    tree = py_trees.trees.BehaviourTree(AsyncSequence(AlwaysSuccess("a"), AlwaysSuccess("b")))
    tree.tick()
    assert tree.root.status is Status.RUNNING
    tree.tick()
    assert tree.root.status is Status.SUCCESS
