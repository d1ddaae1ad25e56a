"""Lines, approaches, following, stopping and changing the pace."""

import re
from functools import partial

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.behaviours import (
    Approach,
    Drop,
    FollowTarget,
    Grasp,
    Hover,
    Lift,
    MoveArc,
    MoveHome,
    MoveLinear,
    MoveThrough,
    MoveToConfiguration,
    MoveToPose,
    PlaceOn,
    Reach,
    Retreat,
    SetSpeed,
    Stop,
    WaitUntilUndisturbed,
    pose_to_text,
)
from bt_manip.bt import NodeStatus
from bt_manip.planning import RRTConnect

RUNNING, SUCCESS, FAILURE = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE
NEAR_HOME = [0.1, -0.6, 0.1, -2.2, 0.1, 1.6, 0.9]
LEFT, RIGHT = [-0.6, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8], [0.6, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8]


def offset(station, T_wt):
    return np.linalg.norm(station.robot.tool_pose.actInv(T_wt).translation)


def push(station, force):
    """Push the hand along y [N]."""
    hand = station.cell.body_id("panda/hand")
    station.cell.data.xfrc_applied[hand][:3] = [0.0, force, 0.0]


@pytest.mark.parametrize(("blend", "nearest"), [(0.05, (0.005, 0.02)), (0.0, (0.0, 1e-3))])
def test_move_through_comes_to_each_pose_or_rounds_its_corners(station, trial, blend, nearest):
    start = station.robot.tool_pose
    corner = pin.SE3(start.rotation, start.translation + [0.0, 0.15, 0.0])
    end = pin.SE3(start.rotation, start.translation + [0.0, 0.15, -0.15])
    text = "|".join(map(pose_to_text, (corner, end)))
    moving = trial(MoveThrough(poses=text, blend=blend))
    away, speeds = [], []
    while moving.tick() is RUNNING:
        away.append(offset(station, corner))
        if away[-1] < 0.05:
            speeds.append(np.linalg.norm(station.robot.tool_velocity[:3]))
    assert offset(station, end) < 2e-3
    assert nearest[0] < min(away) < nearest[1]
    assert (min(speeds) > 0.05) == (blend > 0.0)


def test_move_arc_keeps_its_distance_from_the_centre(station, trial):
    start = station.robot.tool_pose
    centre = start.translation + [0.0, 0.1, 0.0]
    end = pin.SE3(start.rotation, start.translation + [0.0, 0.2, 0.0])
    moving = trial(MoveArc(via=(centre + [0.0, 0.0, -0.1]).tolist(), pose=end))
    lowest = np.inf
    while moving.tick() is RUNNING:
        place = station.robot.tool_pose.translation
        assert np.linalg.norm(place - centre) == pytest.approx(0.1, abs=2e-3)
        lowest = min(lowest, place[2] - centre[2])
    assert lowest == pytest.approx(-0.1, abs=2e-3)
    assert offset(station, end) < 2e-3


def test_approach_and_retreat_go_forth_and_back_along_the_tool(station, trial):
    start = station.robot.tool_pose
    for distance, ports in ((0.08, {"distance": 0.08}), (0.1, {})):
        assert trial(Approach(**ports)).until_done() is SUCCESS
        assert offset(station, start * spatial.pose((0.0, 0.0, distance))) < 2e-3
        assert trial(Retreat(**ports)).until_done() is SUCCESS
        assert offset(station, start) < 2e-3


def test_a_planner_is_chosen_by_name_and_an_unknown_one_fails_the_behaviour(trial, monkeypatch):
    used = []
    monkeypatch.setattr(RRTConnect, "__init__", lambda self: used.append(self))
    moving = trial(MoveToConfiguration(configuration=NEAR_HOME, planner="rrt_connect"))
    assert moving.until_done() is SUCCESS and len(used) == 1
    wrong = trial(MoveToConfiguration(configuration=NEAR_HOME, planner="rrt_conect"))
    assert wrong.fails_with("did you mean 'rrt_connect'")


def test_set_speed_slows_a_running_motion_and_pauses_it_at_zero(station, trial):
    moving = trial(MoveToConfiguration(configuration=LEFT))
    for _ in range(20):
        assert moving.tick() is RUNNING
    assert trial(SetSpeed(speed=0.0, tool_speed=0.1)).tick() is SUCCESS
    assert station.arm.tool_speed == 0.1
    for _ in range(60):
        assert moving.tick() is RUNNING
    assert moving.behaviour.feedback_message == "paused"
    assert not station.arm.v.any()
    assert trial(SetSpeed(speed=1.5)).fails_with("must be a number from 0 to 1, got 1.5")
    assert trial(SetSpeed()).tick() is SUCCESS
    assert station.arm.tool_speed == np.inf
    assert moving.until_done() is SUCCESS
    assert station.robot.q == pytest.approx(LEFT, abs=2e-3)


def test_stop_runs_until_the_arm_rests(station, trial):
    station.arm.move_to_configuration(LEFT)
    station.cell.step(300)
    stopping = trial(Stop())
    assert stopping.tick() is RUNNING
    assert "until rest" in stopping.behaviour.feedback_message
    assert stopping.until_done() is SUCCESS
    assert not station.arm.busy and np.abs(station.robot.v).max() < 0.05
    assert trial(Stop()).tick() is SUCCESS


def test_follow_target_stays_over_what_moves(station, trial):
    following = trial(FollowTarget(object="cube", height=0.2))
    cell = station.cell
    joint, body = cell.model.joint("cube/"), cell.body_id("cube")
    cell.data.qpos[joint.qposadr[0] + 2] += 0.02  # off the table, without weight
    cell.data.qvel[joint.dofadr[0] : joint.dofadr[0] + 3] = [0.0, -0.1, 0.02]
    cell.data.xfrc_applied[body][2] = 9.81 * cell.model.body_subtreemass[body]
    mujoco.mj_forward(cell.model, cell.data)
    worst = 0.0
    for tick in range(200):
        assert following.tick() is RUNNING
        if tick > 150:
            above = station.cell.pose("cube").translation + [0.0, 0.0, 0.2]
            worst = max(worst, np.linalg.norm(station.robot.tool_pose.translation - above))
    assert 0.15 < np.abs(station.cell.pose("cube").translation[1] - 0.1)
    assert worst < 0.02
    following.tree.halt()
    station.cell.step(300)
    assert not station.arm.busy


def test_follow_target_ends_when_its_time_is_over(station, trial):
    began = station.cell.time
    assert trial(FollowTarget(object="cube", duration=0.3)).until_done() is SUCCESS
    assert station.cell.time - began == pytest.approx(0.31, abs=0.011)


LEAST_0 = "must be a number of at least 0"
BEYOND = [0.0, -0.6, 0.0, 0.5, 0.0, 1.6, 0.9]
UP, BELOW = "0.4;0;1.3;0;1;0;0", "0.4;0;0.95;0;1;0;0"


@pytest.mark.parametrize(
    ("behaviour", "ports", "message"),
    [
        (MoveToConfiguration, {"tolerance": 0.0}, "'tolerance' must be a positive number .rad."),
        (MoveToConfiguration, {"wait": np.nan}, f"'wait' {LEAST_0}"),
        (MoveToConfiguration, {"configuration": BEYOND}, "joint 4.*limits"),
        (MoveToConfiguration, {"configuration": [0.0, 0.1]}, "configuration"),
        (MoveHome, {"speed": 0.0}, "speed"),
        (MoveToPose, {"pose": "0.35;-0.2;0.98;0;1;0;0"}, "the target is in collision.*'table'"),
        (MoveToPose, {"pose": UP, "free_axis": "up"}, "free_axis must be 'x', 'y', 'z'"),
        (MoveToPose, {"pose": UP, "cone": 0.1}, "a cone needs a free_axis"),
        (MoveLinear, {"pose": BELOW}, "blocked after.*'table'"),
        (MoveLinear, {"pose": "3;0;1", "free_axis": "z"}, "pose is unreachable: "),
        (Lift, {"height": 1.5}, "line"),
        (Lift, {"height": -0.3}, f"'height' {LEAST_0}"),
        (PlaceOn, {"object": "cube", "support": "table", "gap": -0.01}, f"'gap' {LEAST_0}"),
        (Approach, {"distance": 0.6}, "'table'"),
        (Approach, {"distance": np.inf}, "pose must be finite, got .*inf"),
        (Hover, {"object": "cubee"}, "no 'cubee'.*did you mean 'cube'"),
        (Hover, {"object": "cube", "blend_radius": -0.1}, "blend_radius"),
        (Hover, {"object": "cube", "height": -0.1}, f"'height' {LEAST_0}"),
        (Hover, {"object": "cube", "height": 2.0}, "unreachable, though 'cube' is not"),
        (Reach, {"object": "cube", "grasp": "1;2;3"}, "a grasp is"),
        (FollowTarget, {"object": "cubee"}, "did you mean 'cube'"),
        (FollowTarget, {"object": "cube", "height": 2.0}, "unreachable"),
        (FollowTarget, {"object": "cube", "duration": -1.0}, f"'duration' {LEAST_0} .*-1"),
        (FollowTarget, {"object": "cube", "height": np.nan}, "pose must be finite, got .*nan"),
        (Grasp, {"object": "cube", "patience": -1.0}, f"'patience' {LEAST_0} .s., got -1"),
        (Grasp, {"object": "cube", "force": 500.0}, "500 N"),
        (Grasp, {"object": "cube", "force": -5.0}, f"'force' {LEAST_0}"),
        (Grasp, {"object": "ball"}, "no 'ball'"),
        (Drop, {"container": "basket"}, "the gripper holds nothing"),
        (Drop, {"container": "basket", "height": -0.1}, f"'height' {LEAST_0}"),
        (PlaceOn, {"object": "cube", "support": "table"}, "holds nothing, not 'cube'"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line_and_nothing_moves(
    station, trial, behaviour, ports, message
):
    q, width = station.arm.q_ref, station.gripper.width
    if behaviour is MoveToConfiguration:
        ports = {"configuration": LEFT, **ports}
    trying = trial(behaviour(**ports))
    assert trying.tick() is FAILURE
    said = trying.behaviour.feedback_message
    assert re.search(message, said) and "\n" not in said
    station.cell.step(20)
    assert (station.arm.q_ref == q).all()
    assert station.gripper.width == pytest.approx(width, abs=1e-4)


@pytest.mark.parametrize(
    "behaviour",
    [partial(MoveToConfiguration, configuration=LEFT), partial(FollowTarget, object="cube")],
)
def test_a_pushed_arm_stops_and_the_behaviour_fails_with_the_reason(station, trial, behaviour):
    moving = trial(behaviour())
    for _ in range(15):
        assert moving.tick() is RUNNING
    push(station, 60.0)
    assert moving.fails_with("external force on the arm", "joint", timeout=0.05)
    push(station, 0.0)
    station.cell.step(300)
    assert not station.arm.busy
    assert trial(MoveToConfiguration(configuration=LEFT)).until_done() is SUCCESS


def test_waiting_for_an_undisturbed_arm_lasts_as_long_as_the_push_or_the_patience(station, trial):
    push(station, 60.0)
    station.cell.step(100)
    waiting = trial(WaitUntilUndisturbed())
    for _ in range(50):
        assert waiting.tick() is RUNNING
        assert waiting.behaviour.feedback_message in (
            "the arm moves", "an external force acts on the arm",
        )  # fmt: skip
    patient = trial(WaitUntilUndisturbed(patience=0.3))
    assert patient.fails_with("external force on the arm", "towards (0, 1, 0)", "still after 0.3 s")
    push(station, 0.0)
    assert waiting.until_done() is SUCCESS
    assert station.arm.undisturbed
    assert trial(WaitUntilUndisturbed()).tick() is SUCCESS


def test_a_push_is_noticed_however_often_the_arm_is_redirected(station):
    arm, cell, every = station.arm, station.cell, 3
    start = arm.model.pose(arm.q)
    pushed = None
    for k in range(0, 400, every):
        if not arm.fault:
            arm.follow(pin.SE3(start.rotation, start.translation + [0.0, 0.0, 5e-4 * k]))
        if k >= 200 and pushed is None:
            pushed = cell.time
        push(station, 50.0 if k >= 200 else 0.0)
        cell.step(every)
        assert not arm.fault or pushed is not None
        if arm.fault:
            break
    assert "external force on the arm" in arm.fault and cell.time - pushed <= 0.021
