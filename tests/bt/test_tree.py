"""A tree that runs: ticks, halts, observers, reasons, snapshots and replacing."""

import gc
import json
import os
from functools import partial

import pytest

from bt_manip.bt import (
    Action,
    AlwaysSuccess,
    BehaviourRegistry,
    Condition,
    Fallback,
    Input,
    Inverter,
    NodeStatus,
    Output,
    ParallelAll,
    Script,
    ScriptCondition,
    Sequence,
    Status,
    SubTree,
    SyncAction,
    Tree,
    TreeWatch,
    TryCatch,
    load_tree,
)
from bt_manip.exceptions import NodeError, ScriptError, TreeError


class Work(Action):
    """Work for some ticks, then end as asked."""

    ticks = Input(int, default=2)
    ends = Input(str, default="S")

    def setup(self, *, diary=None, **_):
        self.diary = [] if diary is None else diary

    def initialise(self):
        self.left = self.ticks
        self.diary.append("initialise")
        if self.ends == "at once":
            self.fail("cannot even start")

    def update(self):
        self.left -= 1
        self.diary.append("update")
        if self.left > 0:
            return Status.RUNNING
        return Status.SUCCESS if self.ends == "S" else self.fail("it did not work")

    def terminate(self, new_status):
        self.diary.append(new_status.name)

    def get_state(self):
        return {"left": getattr(self, "left", 0)}

    def set_state(self, state):
        self.left = state["left"]


def tree_of(root, **infrastructure):
    tree = Tree(root, clock=lambda: 0.0)
    tree.setup(**infrastructure)
    return tree


class TestLifeCycle:
    """Actions live as py_trees behaviours do."""

    def test_an_action_is_initialised_updated_and_terminated_as_invalid_when_it_is_halted(self):
        diary = []
        tree = tree_of(Work(), diary=diary)

        assert [tree.tick().name for _ in range(2)] == ["RUNNING", "SUCCESS"]
        assert diary == ["initialise", "update", "update", "SUCCESS"]
        tree.tick()
        tree.halt()
        tree.halt()
        assert diary[4:] == ["initialise", "update", "INVALID"]
        assert tree.root.status is Status.INVALID

    def test_an_action_can_fail_before_its_first_update(self):
        diary = []
        tree = tree_of(Work(ends="at once"), diary=diary)

        assert tree.tick() is NodeStatus.FAILURE
        assert diary == ["initialise", "FAILURE"]
        assert tree.failure_reason() == "Work::1: cannot even start"

    def test_a_skipped_action_leaves_nothing_behind(self):
        class Skip(Action):
            ended = None

            def update(self):
                return NodeStatus.SKIPPED

            def terminate(self, new_status):
                self.ended = new_status

        tree = tree_of(Skip())
        assert tree.tick() is NodeStatus.SKIPPED
        assert tree.root.ended is Status.INVALID
        assert tree.root.engine_status is NodeStatus.IDLE

    @pytest.mark.parametrize(
        ("base", "result", "message"),
        [
            (Action, Status.INVALID, "must not return INVALID"),
            (Action, True, "returned True; expected a Status"),
            (SyncAction, Status.RUNNING, "must not return RUNNING"),
            (Action, None, "Bad needs an update"),
        ],
    )
    def test_an_update_must_return_a_status(self, base, result, message):
        body = {} if result is None else {"update": lambda self: result}
        with pytest.raises(NodeError, match=message):
            tree_of(type("Bad", (base,), body)()).tick()


def test_nodes_are_numbered_and_named_by_path():
    tree = tree_of(
        Sequence("main", [AlwaysSuccess(), SubTree("sub", Sequence(AlwaysSuccess("leaf")))])
    )

    assert [(n.uid, n.path, n.registration) for n in tree.nodes] == [
        (1, "main", "Sequence"),
        (2, "AlwaysSuccess::2", "AlwaysSuccess"),
        (3, "sub::3", "SubTree"),
        (4, "sub/Sequence::4", "Sequence"),
        (5, "sub/leaf", "AlwaysSuccess"),
    ]
    assert tree.node("sub/leaf").uid == 5
    with pytest.raises(TreeError, match="no node 'sub/laef'; did you mean 'sub/leaf'"):
        tree.node("sub/laef")


def test_statuses_print_their_names_and_stay_numbers():
    status = Tree(AlwaysSuccess()).tick()

    assert str(status) == f"{status}" == "SUCCESS"
    assert f"{status:>9}|{NodeStatus.RUNNING!s}" == "  SUCCESS|RUNNING"
    assert repr(status) == "<NodeStatus.SUCCESS: 2>"
    assert json.dumps([status, int(status)]) == "[2, 2]"
    assert status == 2 and bytes([status]) == b"\x02"


def test_what_py_trees_shows_stays_after_completion_and_is_wiped_in_the_next_round():
    class Slowing(Action):
        """Succeed in the first round, run on in the second."""

        rounds = 0

        def update(self):
            self.rounds += 1
            return Status.SUCCESS if self.rounds == 1 else Status.RUNNING

    tree = tree_of(Sequence(Slowing(), AlwaysSuccess()))
    tree.tick()
    assert tree.statuses() == bytes([0, 0, 0])
    assert [child.status for child in tree.root.children] == [Status.SUCCESS, Status.SUCCESS]
    tree.tick()
    assert tree.statuses() == bytes([1, 1, 0])
    assert [child.status for child in tree.root.children] == [Status.RUNNING, Status.INVALID]


def test_observers_hear_of_every_change_also_within_one_tick():
    tree = tree_of(Sequence("s", [AlwaysSuccess("a")]))
    heard = []
    tree.observers.append(lambda node, old, new: heard.append((node.name, old.name, new.name)))
    tree.tick()

    assert heard == [
        ("s", "IDLE", "RUNNING"),
        ("a", "IDLE", "SUCCESS"),
        ("a", "SUCCESS", "IDLE"),
        ("s", "RUNNING", "SUCCESS"),
        ("s", "SUCCESS", "IDLE"),
    ]


def test_a_condition_that_is_running_is_ticked_on_as_in_the_engine_and_says_what_is_odd():
    class Hesitate(Condition):
        looks = 0

        def update(self):
            self.looks += 1
            return Status.SUCCESS if self.looks == 3 else Status.RUNNING

    condition = Hesitate()
    tree = Tree(condition)
    assert [tree.tick() for _ in range(2)] == [NodeStatus.RUNNING] * 2
    assert condition.feedback_message == (
        "a condition returned RUNNING: work that takes time belongs in an Action"
    )
    assert tree.tick() is NodeStatus.SUCCESS


class TestConditionsAroundATick:
    """Pre- and post-conditions of any node."""

    def test_while_halts_a_running_node(self):
        diary = []
        tree = tree_of(Work(ticks=9, while_true="go", on_halted="halted := 1"), diary=diary)
        tree.blackboard["go"] = True
        tree.tick()
        tree.blackboard["go"] = False

        assert tree.tick() is NodeStatus.SKIPPED
        assert diary[-1] == "INVALID" and tree.blackboard["halted"] == 1

    def test_an_exception_in_a_condition_names_its_own_node(self):
        tree = tree_of(Sequence("s", [AlwaysSuccess("a", skip_if="nope > 1")]))

        with pytest.raises(NodeError, match=r"^a \[AlwaysSuccess\]: .*variable not found: nope"):
            tree.tick()

    def test_a_bad_script_is_found_before_anything_runs(self):
        with pytest.raises(ScriptError):
            AlwaysSuccess(skip_if="x ==")

    @pytest.mark.parametrize("hook", ["pre_tick", "post_tick"])
    def test_a_hook_can_replace_the_result_of_a_tick(self, hook):
        node = AlwaysSuccess()
        tree = tree_of(node)
        node.set_tick_hooks(**{hook: lambda *_: NodeStatus.FAILURE})
        assert tree.tick() is NodeStatus.FAILURE

        node.set_tick_hooks()
        assert tree.tick() is NodeStatus.SUCCESS


def test_an_exception_names_the_innermost_node_once():
    class Boom(Action):
        """Cannot be stopped, and explodes at its second tick."""

        count = 0

        def update(self):
            self.count += 1
            return Status.RUNNING if self.count == 1 else 1 / 0

        def terminate(self, new_status):
            raise RuntimeError("stuck")

    tree = tree_of(SubTree("outer", Sequence(Inverter(Boom("fuse")))))
    tree.tick()

    with pytest.raises(NodeError, match=r"^outer/fuse \[Boom\]: division by zero$") as error:
        tree.tick()
    assert isinstance(error.value.__cause__, ZeroDivisionError)
    with pytest.raises(NodeError, match=r"^outer/fuse \[Boom\]: stuck$"):
        tree.halt()


@pytest.mark.parametrize(
    ("root", "reason"),
    [
        (
            SubTree("pick", Sequence(AlwaysSuccess(), Work("grasp", ends="F"))),
            "pick/grasp: it did not work",
        ),
        (
            ParallelAll(  # whose other child ends later
                Work("grasp", ends="F", ticks=1),
                Fallback(Work("recover", ends="F", ticks=3), AlwaysSuccess()),
            ),
            "grasp: it did not work",
        ),
        (ScriptCondition("ok?", code="1 > 2"), "ok?: not: 1 > 2"),
        (AlwaysSuccess("a", failure_if="true"), "a: _failureIf: true"),
        (Inverter("not", AlwaysSuccess("a")), "not: a succeeded"),
        (AlwaysSuccess(), ""),
    ],
)
def test_a_failed_tree_says_which_node_failed_and_why(root, reason):
    tree = tree_of(root)
    while tree.tick() is NodeStatus.RUNNING:
        pass
    assert tree.failure_reason() == reason


class TestState:
    """The state of a tree is plain data, and can be taken back in the middle."""

    def root(self):
        return Sequence(
            "s",
            [
                Script(code="n := 1; name := 'cube'; f := 2.5"),
                SubTree("sub", Work("w", ticks=3), remap={"n": "{n}", "c": "7"}),
                Script(code="n += 1"),
            ],
        )

    def test_a_tree_goes_on_from_a_snapshot(self):
        tree = tree_of(self.root())
        tree.blackboard["seen"], tree.blackboard["last"] = [], None
        tree.tick()
        state = json.loads(json.dumps(tree.get_state()))
        other = tree_of(self.root())
        other.set_state(state)

        assert other.statuses() == tree.statuses()
        assert [other.tick() for _ in range(2)] == [tree.tick() for _ in range(2)]
        assert other.get_state() == tree.get_state()
        assert other.blackboard["n"] == 2 and other.blackboard["name"] == "cube"
        assert (other.blackboard["seen"], other.blackboard["last"]) == ([], None)

    @pytest.mark.parametrize("parent", [partial(ParallelAll, max_failures=2), TryCatch])
    def test_the_reason_of_a_failure_before_the_snapshot_is_kept(self, parent):
        def root():
            return parent("p", Work("first", ticks=1, ends="F"), Work("last", ticks=3, ends="S"))

        tree, other = tree_of(root()), tree_of(root())
        tree.tick()
        other.set_state(json.loads(json.dumps(tree.get_state())))
        for one in (tree, other):
            while one.tick() is NodeStatus.RUNNING:
                pass
        assert other.failure_reason() == tree.failure_reason() == "first: it did not work"

    def test_a_snapshot_of_another_tree_is_refused(self):
        with pytest.raises(TreeError, match="the state is of another tree"):
            tree_of(AlwaysSuccess()).set_state(tree_of(self.root()).get_state())

    def test_values_of_own_types_travel_as_text(self):
        class Point(tuple):
            """A point."""

        class Make(Action):
            point = Output(
                Point,
                parse=lambda text: Point(map(float, text.split(","))),
                format=lambda p: ",".join(map(str, p)),
            )

            def update(self):
                self.point = Point((1.0, 2.0))
                return Status.SUCCESS

        tree = tree_of(Make(point="{p}"))
        tree.tick()
        other = tree_of(Make(point="{p}"))
        other.set_state(json.loads(json.dumps(tree.get_state())))

        assert other.blackboard["p"] == (1.0, 2.0) and isinstance(other.blackboard["p"], Point)


class TestReplacing:
    """A running tree is replaced between two ticks."""

    def test_what_runs_is_halted_and_observers_clock_and_blackboards_stay(self):
        diary, heard = [], []
        tree = tree_of(
            Sequence(Script(code="n := 1"), SubTree("sub", Script(code="i := 5")), Work(ticks=9)),
            diary=diary,
        )
        tree.tick()
        tree.observers.append(lambda *change: heard.append(change))
        new = SubTree("sub", Script(code="i += 1"))
        tree.replace(Tree(Sequence(Script(code="n += 10"), new, Work(ticks=1))))

        assert diary[-1] == "INVALID"
        heard.clear()
        assert tree.tick() is NodeStatus.SUCCESS
        assert diary[-2:] == ["update", "SUCCESS"] and heard
        assert (tree.blackboard["n"], tree.scopes["sub"]["i"], tree.clock()) == (11, 6, 0.0)

    def test_a_tree_whose_setup_fails_does_not_take_over(self):
        class Broken(Action):
            def setup(self, **_):
                raise RuntimeError("no")

        tree = tree_of(AlwaysSuccess())
        with pytest.raises(NodeError):
            tree.replace(Tree(Broken()))
        assert tree.tick() is NodeStatus.SUCCESS

    def test_a_file_that_is_gone_for_a_moment_is_waited_for(self, tmp_path):
        file = tmp_path / "tree.xml"
        text = "<root><BehaviorTree><AlwaysSuccess/></BehaviorTree></root>"
        file.write_text(text)
        registry = BehaviourRegistry()
        watch = TreeWatch(load_tree(file, registry), registry)
        file.unlink()
        assert watch.poll() is None
        file.write_text(text)
        os.utime(file, ns=(1, 1))
        assert watch.poll().errors == ()

    def test_a_tree_without_a_file_cannot_be_watched(self):
        with pytest.raises(TreeError, match="was not read from a file"):
            TreeWatch(Tree(Script(code="x := 1")), BehaviourRegistry())


def test_a_node_cannot_stand_in_a_tree_twice():
    node = AlwaysSuccess()
    Sequence(node)

    with pytest.raises(RuntimeError, match="already has the parent"):
        Sequence(node)


def test_nothing_grows_from_tick_to_tick(bench, leaf):
    body = (
        "<Parallel failure_count='-1' success_count='-1'><Repeat num_cycles='-1'><Timeout "
        f"msec='1000'>{leaf('a', 'RS', mode='cycle')}</Timeout></Repeat>"
        "<KeepRunningUntilFailure><Script code=\"x := x + 1; s := 'a' .. x\"/>"
        "</KeepRunningUntilFailure></Parallel>"
    )
    tree = bench.tree(body)
    tree.blackboard["x"] = 0

    def objects_after(ticks):
        for _ in range(ticks):
            tree.tick()
            bench.log.clear()
        gc.collect()
        return len(gc.get_objects())

    before = objects_after(50)
    assert objects_after(500) <= before + 5
