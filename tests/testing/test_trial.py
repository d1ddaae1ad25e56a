"""A trial ticks until what is wanted, or says why it has not come."""

import pytest

from bt_manip.behaviours import Grasp, Hover, MoveHome, ObjectExists
from bt_manip.bt import Action, Fallback, NodeStatus, Sequence, Sleep
from bt_manip.exceptions import BtManipError, NodeError
from bt_manip.testing.stubs import Stub

PICK = """<root BTCPP_format="4" main_tree_to_execute="Pick">
  <BehaviorTree ID="Pick">
    <Sequence>
      <Script code="asked := force"/>
      <RetryUntilSuccessful num_attempts="3"><Grasp object="cube" force="{force}"/>
      </RetryUntilSuccessful>
      <Lift name="up" height="0.1"/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel><SubTree ID="Pick"><input_port name="force" default="50"/></SubTree>
  </TreeNodesModel>
</root>"""


@pytest.fixture
def pick(tmp_path):
    path = tmp_path / "pick.xml"
    path.write_text(PICK)
    return path


def test_it_ticks_until_a_status_of_the_root(station, trial):
    start = station.cell.time
    assert trial(Sleep(msec=45)).tick_until("SUCCESS") is NodeStatus.SUCCESS
    assert station.cell.time == pytest.approx(start + 0.060)  # ticks at 0, 10, ..., 50 ms


def test_it_ticks_until_a_status_of_a_node(trial):
    running = trial(Sequence("all", Sleep("a", msec=30), Sleep("b", msec=30)))
    running.tick_until("SUCCESS", node="a")
    assert running.history.tick == 4
    assert running.tick() is NodeStatus.RUNNING


def test_it_ticks_until_a_condition(station, trial):
    moving = trial(Hover(object="cube"))
    moving.tick_until(lambda: abs(station.arm.v).max() > 0.5)
    assert moving.tick() is NodeStatus.RUNNING


def test_another_end_is_explained_by_node_tick_tree_and_blackboard(trial):
    running = trial(Sequence("task", Sleep("rest", msec=20), ObjectExists("look", object="{what}")))
    running.blackboard["what"] = "ball"
    with pytest.raises(AssertionError) as error:
        running.tick_until("SUCCESS")
    message = str(error.value)
    assert "expected SUCCESS, the tree ended with FAILURE" in message
    assert "failed: look: the cell has no object 'ball' (tick 3" in message
    assert "+ rest" in message and "x look" in message
    assert "what = 'ball'" in message
    assert "tick 1    " in message and "rest RUNNING" in message


def test_what_takes_too_long_is_explained(trial):
    with pytest.raises(AssertionError, match="expected SUCCESS within 0.05 s, the tree still runs"):
        trial(Hover(object="cube")).tick_until("SUCCESS", timeout=0.05)


def test_a_misspelt_status_or_node_gets_the_nearest(trial):
    running = trial(Sleep("rest", msec=5))
    with pytest.raises(ValueError, match="did you mean 'SUCCESS'"):
        running.tick_until("SUCESS")
    with pytest.raises(AssertionError, match="no node 'rset'; did you mean 'rest'"):
        running.node("rset")


def test_a_failure_for_another_reason_is_no_such_failure(trial):
    assert trial(ObjectExists(object="ball")).fails_with("'ball'")
    with pytest.raises(AssertionError, match="with 'bell' in its reason"):
        trial(ObjectExists(object="ball")).fails_with("bell")
    with pytest.raises(AssertionError, match="ended with SUCCESS"):
        trial(ObjectExists(object="cube")).fails_with("cube")


def test_how_nodes_ended_can_be_asked_afterwards(trial):
    tree = trial(Fallback("any", ObjectExists(object="ball"), MoveHome(), Sleep(msec=1)))
    tree.tick_until("SUCCESS")
    tree.assert_ended("ObjectExists", "FAILURE")
    tree.assert_never_ticked("Sleep")
    with pytest.raises(AssertionError, match="expected 'MoveHome' to end with FAILURE, it ended S"):
        tree.assert_ended("MoveHome", "FAILURE")
    with pytest.raises(AssertionError, match="never to be ticked, it was SUCCESS at tick"):
        tree.assert_never_ticked("MoveHome")


def test_a_document_runs_with_its_keys_and_with_stand_ins(pick, trial):
    grasp, lift = Stub("FAILURE", "SUCCESS", script="found := 3"), Stub(after=0.05)
    tree = trial(pick, substitute={"Grasp": grasp, "up": lift}, force=20)
    tree.tick_until("SUCCESS", timeout=1.0)
    assert (grasp.calls, lift.calls) == (2, 1)
    assert (float(tree.blackboard["asked"]), tree.blackboard["found"]) == (20.0, 3)
    assert tree.tree.clock() == pytest.approx(tree.history.changes[0].time + 0.06, abs=0.011)


def test_halting_a_trial_halts_its_tree(station, trial):
    grasp = trial(Grasp(object="cube"))
    grasp.tick()
    grasp.halt()
    assert grasp.tree.statuses() == bytes([NodeStatus.IDLE])


def test_a_stand_in_for_nothing_is_refused(trial, pick):
    with pytest.raises(
        BtManipError, match="no node of '.*pick.xml' is 'Grsap'; did you mean 'Gras"
    ):
        trial(pick, substitute={"Grsap": Stub()})


@pytest.mark.parametrize("pattern", ["Lift", "up", "u*", "*Grasp::*", "RetryUntilSuccessful"])
def test_a_stand_in_goes_by_name_registered_name_or_path(trial, pick, pattern):
    assert trial(pick, substitute={pattern: Stub()}).tick() is NodeStatus.RUNNING


@pytest.mark.parametrize("what", [Hover, None])
def test_only_a_behaviour_or_a_tree_can_be_tried(trial, what):
    with pytest.raises(TypeError, match="a trial is of a behaviour or a tree, got "):
        trial(what)


def test_a_status_that_is_none_is_refused_with_the_nearest():
    with pytest.raises(ValueError, match="no status 'SUCESS'; did you mean 'SUCCESS'"):
        Stub("SUCESS")


class Stumbling(Action):
    def update(self):
        raise ValueError("a step too far")


def test_a_behaviour_that_raises_leaves_with_the_story_of_the_tree(trial):
    stumbling = trial(Sequence("task", Sleep("rest", msec=5), Stumbling("stumble")))
    with pytest.raises(NodeError, match="a step too far") as caught:
        stumbling.tick_until("SUCCESS")
    (story,) = caught.value.__notes__
    assert "+ rest" in story and "tick 1 " in story
