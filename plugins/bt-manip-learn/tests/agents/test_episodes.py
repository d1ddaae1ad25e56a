"""Episodes start where the tree first commands a robot, and depend on their seed only."""

from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bt_manip.behaviours import Destination, MoveHome
from bt_manip.bt import NodeKind, NodeStatus, Sequence, Sleep, Tree
from bt_manip.cell import Cell
from bt_manip.cell.objects import Cube
from bt_manip.exceptions import BtManipError
from bt_manip.runner import request_of
from bt_manip.spatial import pose
from bt_manip_learn.agents import (
    Episodes,
    LossCheck,
    SubtreeChoice,
    action_kind,
    goal_progress,
    held_payload,
)
from bt_manip_learn.agents.progress import placing_progress


@pytest.fixture(scope="module")
def episodes(parts):
    return Episodes(request_of("pick_place", parts), parts)


def test_what_the_tree_does_before_it_commands_a_robot_is_done(episodes):
    episodes.reset(0)
    assert "cube" in episodes.station.cell.objects and episodes.steps == 0
    assert not episodes.station.robot.v.any()
    episodes.expert_step()
    assert episodes.gripped == {} and episodes.steps == 1  # no gripper was commanded


def test_the_expert_does_nothing_more_where_the_goal_holds(episodes, monkeypatch):
    episodes.reset(0)
    ticks = []
    monkeypatch.setattr(episodes.run.tree, "tick", lambda: ticks.append(0) or NodeStatus.RUNNING)
    for held, count in ((False, 1), (True, 1)):
        monkeypatch.setattr(Episodes, "success", held)
        assert episodes.tick() is NodeStatus.RUNNING and len(ticks) == count


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
    assert (episodes.seed, episodes.episode, episodes.steps) == (0, 0, 0)
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


def test_a_tree_may_command_its_robot_after_a_while_but_within_ten_seconds(
    parts, tmp_path, monkeypatch
):
    path = tmp_path / "task.xml"
    move = '<Sleep msec="500"/><Sequence><MoveHome/><OpenGripper/></Sequence>'
    path.write_text(TREE.format(move))
    episodes = Episodes(request_of(str(path), parts), parts)
    episodes.reset(0)
    assert episodes.station.cell.time == pytest.approx(0.5, abs=0.05)
    kind, one = action_kind("joint_targets", episodes), episodes.station.first
    starts, reset, away = [], one.arm.reset, one.robot.q + 0.05
    monkeypatch.setattr(one.arm, "reset", lambda q: starts.append(q) or reset(q))
    for lag, kept in ((-0.06, -0.06), (0.11, 0.0)):  # [rad] of joint 7, from where it is
        for _ in range(4):  # until it rests
            kind.step([*away, -1.0])
        q = one.robot.q
        one.controllers.reference.q[:] = q + lag * np.eye(7)[6]
        episodes.expert_step()  # the tree starts again behind the leaves before the first command
        assert starts[-1] == pytest.approx(q + kept * np.eye(7)[6])
        statuses = [node.engine_status.name for node in episodes.run.tree.nodes]
        assert statuses == ["RUNNING", "SUCCESS", "SUCCESS", "RUNNING", "RUNNING", "IDLE"]
    path.write_text(TREE.format('<Sleep msec="60000"/><MoveHome/>'))
    with pytest.raises(BtManipError, match="commanded no robot within 10 s"):
        Episodes(request_of(str(path), parts), parts).reset(0)


def test_actions_are_bounded_by_the_limits_of_the_joints_and_those_of_the_tool(
    episodes, monkeypatch
):
    model = episodes.station.arm.model
    limits = model.limits
    lower, upper = limits.lower.copy(), limits.upper.copy()
    lower[2], upper[4] = -np.inf, np.inf
    monkeypatch.setattr(model, "limits", replace(limits, lower=lower, upper=upper))
    lower[2], upper[4] = -2 * np.pi, 2 * np.pi
    tool = np.repeat([2.0, 4 * np.pi], 3) * episodes.step_time  # [m/s], [rad/s]
    bounds = {
        "joint_targets": (lower, upper, "rad"),
        "joint_torques": (-limits.effort, limits.effort, "N m"),
        "cartesian_deltas": (-tool, tool, "rad"),
    }
    for name, (low, high, unit) in bounds.items():
        space = action_kind(name, episodes).space
        np.testing.assert_allclose(space.low, [*low, -1.0], rtol=1e-6)
        np.testing.assert_allclose(space.high, [*high, 1.0], rtol=1e-6)
        linear = 3 * (name == "cartesian_deltas")
        assert space.units == (*["m"] * linear, *[unit] * (len(low) - linear), "-")


def test_a_step_takes_its_time_with_any_step_of_the_physics(episodes, monkeypatch):
    episodes.reset(0)
    monkeypatch.setattr(episodes.station.cell.model.opt, "timestep", 2e-3)
    (reference,) = action_kind("joint_targets", episodes).take_over()
    reference.move_to(reference.q + 0.01, reference.q)
    positions, *_ = reference.finish()
    assert len(positions) == 25
    assert reference.v == pytest.approx([1.5 * 0.01 / 0.05] * 7)  # the end of a parabola


def test_torques_of_an_agent_and_of_the_expert_are_beside_gravity_and_coriolis(episodes):
    episodes.reset(2)
    for _ in range(4):
        episodes.expert_step()
    kind, cell = action_kind("joint_torques", episodes), episodes.station.cell
    robot, torques = episodes.station.robot, np.arange(1.0, 8.0)
    bias = cell.data.qfrc_bias[robot.dof_adr]
    kind.watch()
    np.testing.assert_allclose(kind.recorded()[:-1], robot.tau - bias, atol=0.05)
    kind.command([*torques, -1.0])
    control, still = episodes.station.controller, np.zeros(7)
    mujoco.mj_forward(cell.model, cell.data)
    bias = cell.data.qfrc_bias[robot.dof_adr]
    tau = control.compute(robot.q, robot.v, still, still, still)
    np.testing.assert_allclose(tau, bias + torques, atol=0.05)


def test_of_two_robots_each_follows_its_own_numbers_and_an_object_is_lost_for_both(parts):
    episodes = Episodes(request_of("two_arms", parts), parts)
    episodes.reset(0)
    kind, robots = action_kind("joint_targets", episodes), list(episodes.station.robots.values())
    moves = np.random.default_rng(0).uniform(-0.01, 0.01, (2, 7))
    grips = 0.4, -0.7  # closes 3 of 5 ticks later; is open already
    targets = [one.arm.q + move for one, move in zip(robots, moves, strict=True)]
    action = np.concatenate([[*q, grip] for q, grip in zip(targets, grips, strict=True)])
    references = kind.take_over()
    references[1].payload = "held before"
    kind.command(action)
    assert references[1].payload is None
    for reference, q in zip(references, targets, strict=True):
        reference.finish()
        assert reference.q == pytest.approx(q, abs=1e-6)
    assert kind.waiting
    closing = [kind.tick() and [one.gripper.gripping for one in robots] for _ in range(5)]
    assert closing == [[False, False]] * 3 + [[True, False]] * 2
    episodes.gripped = {robots[0].name: 3}
    np.testing.assert_allclose(kind.recorded(), [*action[:-1], -1.0], atol=1e-6)
    cell, loss = episodes.station.cell, LossCheck(episodes)
    (name,) = [one for one in cell.objects if cell.is_free(one)][:1]
    left, right = (one.arm.model.model.jointPlacements[1].translation for one in robots)
    for sideways, reason in ((0.6, ""), (3.0, f"'{name}' is out of reach")):
        place = left + sideways * (left - right) / np.linalg.norm(left - right)
        cell.move(name, pose(place), overlap=9.0)
        assert loss.reason() == reason


def test_choices_are_parts_below_the_root_that_use_a_robot_and_belong_to_the_state(episodes):
    several = Sequence("all", MoveHome("b"), Sleep("c"), MoveHome("d"))
    for root, paths in ((MoveHome("a"), []), (several, ["b", "d"])):
        run, station = SimpleNamespace(tree=Tree(root)), SimpleNamespace(robots={})
        few = SubtreeChoice(SimpleNamespace(run=run, station=station))
        assert few.space.choices == ("", *paths)
        assert (few.space.low, few.space.high) == ([0.0], [len(paths)])
    episodes.reset(3)
    kind, other = (action_kind("subtree_choice", episodes) for _ in range(2))
    nodes, choices = episodes.run.tree.nodes, kind.space.choices
    parts = {one.path for one in nodes[1:] if one.kind is NodeKind.SUBTREE}
    assert parts and parts < set(choices)
    running = [one.path for one in nodes if one.engine_status.name == "RUNNING"]
    assert choices[kind.recorded()] == [path for path in running if path in choices][-1]
    for number in (0, 2, len(choices) - 1):
        kind.command(number)
        assert kind.get_state() == {"running": number, "status": "IDLE"}
        other.set_state(kind.get_state())
        assert other.get_state() == kind.get_state()
    for number in (-1, len(choices)):
        with pytest.raises(BtManipError, match=f"a number from 0 to {len(choices) - 1}, got"):
            kind.command(number)


def test_an_object_of_the_goal_is_lost_beyond_the_stretched_arm_or_below_everything(episodes):
    episodes.reset(0)
    loss, cell = LossCheck(episodes), episodes.station.cell
    model = episodes.station.arm.model
    assert loss.reason() == ""
    # The farthest tool position from the shoulder, over random configurations.
    rng = np.random.default_rng(0)
    lower, upper = model.limits.sampling_bounds()
    shoulder = model.model.jointPlacements[1].translation
    tools = [model.pose(q).translation for q in rng.uniform(lower, upper, (2000, model.nq))]
    reached = max(tools, key=lambda tool: np.linalg.norm(tool - shoulder))
    x, y, z = cell.pose("cube").translation
    lowest = min(z, *(cell.pose(name).translation[2] for name in ("basket", "panda")))
    for position, reason in (
        (reached, ""),
        (shoulder + 1.6 * (reached - shoulder), "'cube' is out of reach"),
        ((x, y, lowest - 0.11), "'cube' has fallen"),
        ((x, y, lowest - 0.09), ""),
    ):
        cell.move("cube", pose(position), overlap=9.0)
        assert loss.reason() == reason


def test_a_held_object_is_the_payload_of_an_agent_once_the_grip_is_steady():
    cell = Cell()
    cell.add(Cube(mass=0.3), pose((0.3, -0.2, 0.5)))
    T_wt = pose((0.28, -0.2, 0.53), (0.0, 1.0, 0.0, 0.0))
    grip = SimpleNamespace(gripping=True, steady=False, held=("cube",))
    assert held_payload(cell, grip, T_wt, None) is None
    grip.steady = True
    payload = held_payload(cell, grip, T_wt, None)
    assert payload.mass == pytest.approx(0.3)
    assert payload.com == pytest.approx(T_wt.actInv(cell.pose("cube").translation), abs=1e-9)
    assert held_payload(cell, grip, pose((0.0, 0.0, 0.0)), payload) is payload
    grip.gripping = False
    assert held_payload(cell, grip, T_wt, payload) is None


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
    assert placing_progress(cell, robots, {}) == 0.0
    # Conditions that do not hold: 0.9 of 0.6 of this and 0.4 of their own progress, 0 to 1.
    for own, expected in ((0.25, 0.25), (-0.5, 0.0), (1.7, 1.0)):
        condition = SimpleNamespace(places=lambda: {"cube": place}, progress=lambda own=own: own)
        run = SimpleNamespace(
            goal=SimpleNamespace(reasons=lambda: ["no", "", ""]),
            tree=SimpleNamespace(goal=[condition] * 3),
        )
        episodes = SimpleNamespace(run=run, station=SimpleNamespace(cell=cell, robots=robots))
        mean = (0.9 * (0.6 + 0.4 * expected) + 1.0 + 1.0) / 3
        assert goal_progress(episodes) == pytest.approx(mean, abs=1e-6)


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
    cell.move("a", pose((0.2, 0.3, 0.11)), overlap=9.0)  # 1 cm deeper than it may sink
    placed = 0.5 * 0.2 / (0.2 + 0.01) + 0.4 * 0.5 + 0.1 * 0.5 * 0.2 / (0.2 + 0.015)
    assert placing_progress(cell, robots, {"a": place}) == pytest.approx(placed, rel=1e-6)


@pytest.mark.parametrize("lag", [-0.06, 0.06, -0.04])
def test_a_commanded_pose_that_the_arm_could_not_follow_is_forgotten(episodes, lag):
    episodes.reset(0)
    kind = action_kind("cartesian_deltas", episodes)
    (reference,) = kind.take_over()
    model = episodes.station.arm.model
    T = model.pose(reference.q).copy()
    last = T.copy()
    last.translation[0] += lag
    reference.T_wt = last
    delta, turn = [0.002, -0.003, 0.001], [0.02, -0.01, 0.03]
    kind.command([*delta, *turn, -1.0])
    start = T if abs(lag) > 0.05 else last
    assert reference.T_wt.translation == pytest.approx(start.translation + delta)
    rotation = Rotation.from_rotvec(turn).as_matrix() @ T.rotation
    assert reference.T_wt.rotation == pytest.approx(rotation)
