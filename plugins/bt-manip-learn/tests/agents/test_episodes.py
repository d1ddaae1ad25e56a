"""Episodes start where the tree first commands a robot, and depend on their seed only."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.behaviours import Destination
from bt_manip.cell import Cell
from bt_manip.cell.objects import Cube
from bt_manip.exceptions import BtManipError
from bt_manip.runner import request_of
from bt_manip.spatial import pose
from bt_manip_learn.agents import Episodes, action_kind, goal_progress
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
    beside = pose((0.3 + 0.09, -0.2, 0.025))  # its width, 5 cm, is free of walls to 7.5 cm
    cell.move("cube", beside, overlap=1.0)
    assert placing_progress(cell, robots, {"cube": place}) == pytest.approx(1.0, abs=1e-6)
    walled = place._replace(walls=True)
    assert placing_progress(cell, robots, {"cube": walled}) < 0.9
    cell.move("cube", pose((0.3 + 0.07, -0.2, 0.025)), overlap=1.0)
    assert placing_progress(cell, robots, {"cube": walled}) == pytest.approx(1.0, abs=1e-6)
    # A condition that is not yet held: 0.9 of 0.6 of this and 0.4 of its own progress.
    condition = SimpleNamespace(places=lambda: {"cube": place}, progress=lambda: 0.25)
    run = SimpleNamespace(
        goal=SimpleNamespace(reasons=lambda: ["no"]), tree=SimpleNamespace(goal=[condition])
    )
    episodes = SimpleNamespace(run=run, station=SimpleNamespace(cell=cell, robots=robots))
    assert goal_progress(episodes) == pytest.approx(0.9 * (0.6 + 0.4 * 0.25), abs=1e-6)


def test_the_progress_of_several_objects_counts_reaching_and_holding_one_of_them():
    cell = Cell()
    cell.add(Cube(), pose((0.5, 0.0, 0.325)), name="a")  # its bottom at 0.3
    cell.add(Cube(), pose((0.0, 0.4, 0.025)), name="b")
    box = np.array([[0.06, 0.04, 0.0]])
    place = Destination(pose((0.2, 0.3, 0.1)), -box, box + [0.0, 0.0, 0.05])
    robots = {
        name: SimpleNamespace(
            robot=SimpleNamespace(tool_pose=pose(at)), gripper=SimpleNamespace(held=held)
        )
        for name, at, held in (("one", (0.5, 0.1, 0.325), ["a"]), ("two", (1.0, 1.0, 1.0), []))
    }
    # Sideways to the edge; a is above the walls, b 10 cm below the bottom.
    aside, below = np.hypot(0.3 - 0.06, 0.3 - 0.04), np.hypot(0.2 - 0.06, 0.1 - 0.04)
    there = [0.5 * 0.2 / (0.2 + d) for d in (aside, below + 0.15)]
    places = {"a": place, "b": place, "c": None, "gone": place}
    found = placing_progress(cell, robots, places)
    assert found == pytest.approx((sum(there) + 0.2 + 0.2) / 4, rel=1e-6)
    robots["one"].gripper.held = []
    found = placing_progress(cell, robots, places)
    assert found == pytest.approx((sum(there) + 0.2 * 0.2 / 0.3) / 4, rel=1e-6)
    cell.move("a", pose((0.26 + 0.01, 0.3, 0.145)), overlap=1.0)  # half over the edge, 2 cm up
    over, placed = 0.5, 0.5 * 0.2 / (0.2 + 0.01 + 0.5 * 0.03) + 0.4 * 0.5 + 0.1 * 0.5 / 1.1
    near = np.sqrt(0.23**2 + 0.2**2 + 0.18**2)
    handled = max(0.2 * (0.2 / (0.2 + near) - over), 0.2 * 0.2 / (0.2 + np.sqrt(0.34 + 0.09)))
    found = placing_progress(cell, robots, {"a": place, "b": place})
    assert found == pytest.approx((placed + there[1] + handled) / 2, rel=1e-6)


@pytest.mark.parametrize("lag", [-0.3, 0.3, -0.03])
def test_a_commanded_pose_that_the_arm_could_not_follow_is_forgotten(episodes, lag):
    episodes.reset(0)
    kind = action_kind("cartesian_deltas", episodes)
    assert kind.space.units == ("m", "m", "m", "rad", "rad", "rad", "-")
    (reference,) = kind.take_over()
    model = episodes.station.arm.model
    T = model.pose(reference.q).copy()
    last = T.copy()
    last.translation[0] += lag
    reference.T_wt = last
    kind.command([0.002, 0.0, 0.001, 0.0, 0.0, 0.0, -1.0])
    start = T if abs(lag) > 0.05 else last
    assert reference.T_wt.translation == pytest.approx(start.translation + [0.002, 0.0, 0.001])
    assert reference.T_wt.rotation == pytest.approx(T.rotation)
