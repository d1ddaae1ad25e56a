"""Episodes start where the tree first commands a robot, and depend on their seed only."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.behaviours import Destination
from bt_manip.cell import Cell
from bt_manip.cell.objects import Cube
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip.runner import request_of
from bt_manip.spatial import pose
from bt_manip_learn.agents import Episodes, action_kind
from bt_manip_learn.agents.progress import placing_progress


@pytest.fixture(scope="module")
def episodes(parts):
    return Episodes(request_of("pick_place", parts), parts)


def test_what_the_tree_does_before_it_commands_a_robot_is_done(episodes):
    episodes.reset(0)
    assert "cube" in episodes.station.cell.objects
    assert not episodes.station.robot.v.any()


TREE = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Task" _goal="IsIn object={{cube}} container=basket">
    <Sequence><SpawnObject object="{{cube}}"/>{}</Sequence>
  </BehaviorTree>
</root>
"""


def test_a_tree_that_commands_no_robot_is_a_task_without_expert(parts, tmp_path):
    path = tmp_path / "task.xml"
    path.write_text(TREE.format(""))
    episodes = Episodes(request_of(str(path), parts), parts)
    episodes.reset(0)
    kind = action_kind("joint_targets", episodes)
    q = episodes.station.robot.q
    for _ in range(4):
        kind.step(np.append(q + 0.05, 1.0))
    assert (episodes.station.robot.q > q).all()
    with pytest.raises(BtManipError, match="cannot take over: its tree commands no robot"):
        episodes.expert_step()
    path.write_text(TREE.format("<AlwaysFailure/>"))
    with pytest.raises(BtManipError, match="failed before it commanded a robot: AlwaysFailure"):
        Episodes(request_of(str(path), parts), parts).reset(0)


def test_a_tree_may_command_its_robot_after_a_while_but_within_ten_seconds(parts, tmp_path):
    path = tmp_path / "task.xml"
    path.write_text(TREE.format('<Sleep msec="500"/><MoveHome/>'))
    episodes = Episodes(request_of(str(path), parts), parts)
    episodes.reset(0)
    assert episodes.station.cell.time == pytest.approx(0.5, abs=0.05)
    path.write_text(TREE.format('<Sleep msec="60000"/><MoveHome/>'))
    with pytest.raises(BtManipError, match="commanded no robot within 10 s"):
        Episodes(request_of(str(path), parts), parts).reset(0)


def test_an_episode_does_not_depend_on_those_before_it(episodes, parts):
    episodes.reset(5)
    episodes.expert_step()
    episodes.reset(3)
    episodes.expert_step()
    fresh = Episodes(request_of("pick_place", parts), parts)
    fresh.reset(3)
    fresh.expert_step()
    assert episodes.station.cell.state_bytes() == fresh.station.cell.state_bytes()


@pytest.mark.parametrize("name", load_plugins().parts.of("actions"))
def test_actions_of_every_kind_make_a_step(episodes, name):
    episodes.reset(2)
    kind = action_kind(name, episodes)
    start = episodes.station.cell.time
    for _ in range(3):
        kind.step(kind.space.low if kind.space.shape else 0)
    assert episodes.station.cell.time == pytest.approx(start + 0.15)


def test_a_state_continues_bit_for_bit(episodes, parts):
    episodes.reset(4)
    kind = action_kind("joint_targets", episodes)
    target = np.append(episodes.station.robot.q + 0.05, 1.0)
    for _ in range(3):
        kind.step(target)
    state = {"episode": episodes.get_state(), "action": kind.get_state()}
    kind.step(target)
    other = Episodes(request_of("pick_place", parts), parts)
    other.set_state(state["episode"])
    again = action_kind("joint_targets", other)
    again.set_state(state["action"])
    again.step(target)
    assert other.station.cell.state_bytes() == episodes.station.cell.state_bytes()


def test_a_step_in_which_no_gripper_is_commanded_says_so(episodes):
    episodes.reset(1)
    episodes.expert_step()
    assert episodes.gripped == {}


def test_targets_of_joints_are_bounded_by_their_limits(episodes):
    limits, space = episodes.station.arm.model.limits, action_kind("joint_targets", episodes).space
    np.testing.assert_allclose(space.low[:-1], limits.lower, rtol=1e-6)
    np.testing.assert_allclose(space.high[:-1], limits.upper, rtol=1e-6)


def test_an_object_at_its_place_has_made_all_progress():
    cell = Cell()
    cell.add(Cube(), pose((0.3, -0.2, 0.025)))
    box = np.array([[0.1, 0.1, 0.0]])
    place = Destination(pose((0.3, -0.2, 0.0)), -box, box)
    tool = SimpleNamespace(tool_pose=pose((0.0, 0.0, 1.0)))
    robots = {"arm": SimpleNamespace(robot=tool, gripper=None)}
    assert placing_progress(cell, robots, {"cube": place}) == pytest.approx(1.0, abs=1e-6)
