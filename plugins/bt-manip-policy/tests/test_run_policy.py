"""A policy acts as a leaf: what it moves, what stops it, and why it fails."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.behaviours import Hover, SpawnObject
from bt_manip.bt import AlwaysSuccess, Fallback, NodeStatus, Sequence, Sleep, Tree
from bt_manip.exceptions import NodeError
from bt_manip.plugins import load_plugins
from bt_manip.record import Recorder
from bt_manip.runner import Run, RunRequest, TreeSource
from bt_manip.spatial import pointing_down
from bt_manip_policy import RunPolicy, policy_process
from bt_manip_policy.policy_inputs import with_history
from bt_manip_policy.policy_kind import ONNX

from . import onnx_files as onnx

TOOL = {"robot_tool_position": (3,)}


@pytest.fixture(scope="module")
def built():
    parts = load_plugins().parts
    parts.of("policies").add("quick", replace(ONNX, load_time=0.5, time=0.5), "tests")
    station = build_station(parts)
    return station, station.get_state()


@pytest.fixture
def station(built):
    station, state = built
    station.set_state(state)
    return station


@pytest.fixture
def policy(tmp_path):
    """Write a policy: an offset, inputs, and more arguments of `onnx_files.linear`."""

    def write(offset, inputs=TOOL, weights=None, **metadata):
        path = tmp_path / "policy.onnx"
        path.write_bytes(onnx.linear(offset, inputs, weights, **metadata))
        return str(path)

    return write


class Acting:
    """Ticks a policy and keeps the reference of each control step."""

    def __init__(self, station, **ports):
        self.station, self.leaf = station, RunPolicy("policy", **ports)
        self.tree = Tree(self.leaf, clock=station.clock)
        self.tree.setup(**station.infrastructure)
        self.rows, self.status = [], NodeStatus.RUNNING

    def run(self, duration, tick=10):
        arm = self.station.arm
        for _ in range(round(duration / (1e-3 * tick))):
            if self.status is NodeStatus.RUNNING:
                self.status = self.tree.tick()
            for _ in range(tick):
                self.station.cell.step()
                self.rows.append((arm.q.copy(), arm.v.copy(), arm.a.copy()))
        return self

    def check_limits(self):
        limits = self.station.arm.model.limits
        q, v, a = (np.array(rows) for rows in zip(*self.rows, strict=True))
        assert limits.contain(q.min(axis=0), 1e-9) and limits.contain(q.max(axis=0), 1e-9)
        assert (np.abs(v) <= limits.velocity * 1.000001).all()
        assert (np.abs(a) <= limits.acceleration * 1.000001).all()


def tool(station):
    return station.arm.model.pose(station.arm.q)


def test_cartesian_deltas_add_up_and_then_time_is_up(station, policy):
    start = tool(station)
    model = policy([0.005, 0.0, -0.003, 0.0, 0.0, 0.02, -1.0])
    acting = Acting(station, model=model, time_limit=0.5).run(1.5)
    moved, turned = tool(station).translation - start.translation, tool(station).rotation
    assert acting.status is NodeStatus.FAILURE
    assert "0.5 s" in acting.leaf.feedback_message and RunPolicy("policy").time_limit == 10.0
    # Ten actions, and the stop after the last one.
    assert np.allclose(moved, [0.05, 0.0, -0.03], atol=4e-3)
    assert np.allclose(turned, pointing_down([0, 0, 0], 0.2).rotation, atol=0.02)
    assert not station.arm.v.any()
    acting.check_limits()


def test_a_gripper_closes_later_in_the_step_for_a_smaller_number(station, policy):
    acting = Acting(station, model=policy([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.4]))  # 20 Hz
    closing = [acting.run(0.01) and station.gripper.gripping for _ in range(6)]
    assert closing == [False] * 3 + [True] * 3


def test_joint_targets_are_reached(station, policy):
    target = station.arm.q_ref + 0.1
    model = policy([*target, 1.0], action="joint_targets")
    acting = Acting(station, model=model, time_limit=1.0).run(1.2)
    assert np.allclose(station.arm.robot.q, target, atol=2e-3)
    assert station.gripper.closed_on_nothing
    acting.check_limits()


def averaged(rows, k):
    """The last four predictions for a step: the oldest one weighs most (Zhao et al., 2023)."""
    present = rows[min(k, 3) :: -1]
    return np.average(present, axis=0, weights=np.exp(-0.5 * np.arange(len(present))))


@pytest.mark.parametrize(
    ("described", "action"),
    [
        ({}, lambda rows, k: rows[k % 4]),
        ({"execute": "2"}, lambda rows, k: rows[k % 2]),
        ({"ensemble": "0.5"}, averaged),
    ],
)
def test_rows_of_actions_are_executed_in_turn_left_early_or_averaged(
    station, policy, monkeypatch, described, action
):
    arm, start, T = station.arm, station.arm.q_ref, 0.04
    moves = np.random.default_rng(0).uniform(-0.01, 0.01, (4, 7))
    rows, commands, servo = start + moves, [], arm.servo

    def note(q, v, duration, *, contact):
        commands.append((station.cell.time, *q, *v, duration, contact))
        servo(q, v, duration, contact=contact)

    monkeypatch.setattr(arm, "servo", note)
    model = policy(np.c_[rows, -np.ones(4)], action="joint_targets", rate="25", **described)
    begin = station.cell.time
    Acting(station, model=model).run(0.4)
    before, change = start, np.zeros(7)
    for k, command in enumerate(commands):
        q = action(rows, k)
        v = (3 * (q - before) - change) / (2 * T)  # at the end of a parabola
        before, change = q, q - before
        assert command == pytest.approx((begin + k * T, *q, *v, T, False), abs=1e-5)
    assert len(commands) == 10


def test_observations_of_the_object_of_the_port_are_called_object(station, policy):
    """A policy that leads the tool to a point beside the object."""
    beside = np.array([-0.25, 0.1, 0.4])
    weights = {"object_position": 0.1 * np.eye(3, 7), "robot_tool_position": -0.1 * np.eye(3, 7)}
    model = policy([*(0.1 * beside), 0, 0, 0, -1], {**TOOL, "object_position": (3,)}, weights)
    Acting(station, model=model, object="basket").run(3.0).check_limits()
    where = station.cell.pose("basket").translation + beside
    assert np.allclose(tool(station).translation, where, atol=2e-3)


def test_limits_hold_whatever_the_policy_wants(station, policy):
    rng = np.random.default_rng(0)
    low, high = station.arm.model.limits.lower, station.arm.model.limits.upper
    targets = np.column_stack([rng.uniform(low - 1.0, high + 1.0, (40, 7)), -np.ones(40)])
    targets[:, 1:4] = station.arm.q_ref[1:4] + rng.uniform(-0.3, 0.3, (40, 3))  # free of contact
    model = policy(targets, action="joint_targets")
    acting = Acting(station, model=model, time_limit=2.0).run(3.0)
    acting.check_limits()
    assert not station.arm.v.any()


def test_an_external_force_stops_the_arm_and_is_the_reason(station, policy):
    model = policy([0.0, 0.0, -0.02, 0.0, 0.0, 0.0, -1.0])
    acting = Acting(station, model=model, time_limit=9.0).run(6.0)
    assert acting.status is NodeStatus.FAILURE
    assert "external force" in acting.leaf.feedback_message
    assert station.arm.at_rest


def test_halting_stops_the_arm_within_its_limits_and_hover_goes_on(station, policy):
    acting = Acting(station, model=policy([0.02, 0.02, -0.01, 0.0, 0.0, 0.0, 1.0])).run(0.4)
    assert np.abs(station.arm.v).max() > 0.1
    acting.tree.halt()
    acting.status = NodeStatus.IDLE
    acting.run(0.6)
    acting.check_limits()
    assert station.arm.at_rest and not station.gripper.moving
    result = station.run(Hover(object="basket", height=0.3))
    assert result.status is NodeStatus.SUCCESS, result.reason


@pytest.mark.parametrize(
    ("offset", "inputs", "metadata", "reason"),
    [
        ([0.0, np.inf, 0, 0, 0, 0, 0], TOOL, {}, "not finite"),
        (np.zeros(7), TOOL, {"rate": "1000"}, "ticked less often"),
        (np.zeros(7), {"cube_position": (3,)}, {}, "'cube_position', which the station lacks"),
    ],
)
def test_a_policy_that_cannot_act_at_a_tick_fails(
    station, policy, offset, inputs, metadata, reason
):
    acting = Acting(station, model=policy(offset, inputs, **metadata)).run(0.1)
    assert acting.status is NodeStatus.FAILURE
    assert reason in acting.leaf.feedback_message
    assert not station.arm.moving


@pytest.mark.parametrize(
    ("offset", "inputs", "metadata", "reason"),
    [
        (np.zeros(7), TOOL, {"action": "joint_torques"}, "did you mean 'joint_targets'"),
        (np.zeros(6), TOOL, {}, "returned values of shape 6, .* of this robot has 7"),
        (np.zeros(7), TOOL, {"action": "joint_targets"}, "of this robot has 8"),
        (np.zeros(7), {"robot_tools_position": (3,)}, {}, "did you mean 'robot_tool_position'"),
        (np.zeros(7), {"robot_joint_positions": (6,)}, {}, "size 6, the station's has 7"),
        (np.zeros(7), {"front_rgb": (128, 128, 3)}, {}, "'front_rgb', which the station"),
        (np.zeros(7), {"table_position": (3,)}, {}, "'table_position', which the station"),
        (np.zeros(7), {"object_position": (3,)}, {}, "'object_position', which the station"),
        (np.zeros(7), {"cube_positions": (3,)}, {}, "'cube_positions', which the station"),
        (np.zeros(7), {"cube_position": (4,)}, {}, "size 4, the station's has 3"),
        (np.zeros(7), {"cube_rotation": (5,)}, {}, "size 5, the station's has 6"),
        (np.zeros(7), {"cube_velocity": (7,)}, {}, "size 7, the station's has 6"),
        (np.zeros(7), {"cube_contact_wrench": (3,)}, {}, "size 3, the station's has 6"),
        (np.zeros(7), {"overview_rgb": (24, 32, 3), "overview_depth": (1, 16)}, {},
         "images of several sizes"),
    ],
)  # fmt: skip
def test_a_policy_that_does_not_fit_is_refused_before_the_run(
    station, policy, offset, inputs, metadata, reason
):
    with pytest.raises(NodeError, match=reason):
        Acting(station, model=policy(offset, inputs, **metadata))


# Runs a command and prints its peak memory [KB]. A process counts the peak of the one that started
# it as its own, so that a large test process must not start the command itself.
PEAK_MEMORY = """
import resource, subprocess, sys
code = subprocess.run(sys.argv[1:]).returncode
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(code)
"""


def test_a_policy_that_cannot_act_is_refused_before_the_run(station, tmp_path):
    path = tmp_path / "policy.onnx"
    with pytest.raises(NodeError, match="No such file"):
        Acting(station, model=str(path))
    with pytest.raises(NodeError, match="'onx'; did you mean 'onnx'"):
        Acting(station, model=str(path), policy_kind="onx")
    path.write_bytes(onnx.endless())
    with pytest.raises(NodeError, match="takes longer than 0.5 s"):
        Acting(station, model=str(path), policy_kind="quick")


def test_a_policy_that_hangs_at_a_tick_fails_and_the_tree_goes_on(station, tmp_path):
    """The file acts when it is checked, and computes without end once there is a cube."""
    path = tmp_path / "policy.onnx"
    path.write_bytes(onnx.endless("cube_position"))
    leaf = RunPolicy("policy", model=str(path), policy_kind="quick")
    spawn = SpawnObject(model="cube", region="0.3;0.3;0;0", object="{cube}")
    tree = Fallback("or", [Sequence("all", [spawn, leaf]), AlwaysSuccess()])
    assert station.run(tree).status is NodeStatus.SUCCESS
    assert "takes longer than 0.5 s" in leaf.feedback_message


def test_the_report_says_that_a_policy_that_fails_at_once_did_nothing(station, policy):
    shares = []
    for offset in (np.zeros(7), [0.0, np.nan, 0, 0, 0, 0, 0]):
        leaf = RunPolicy("policy", model=policy(offset), time_limit=0.3)
        tree = Tree(Fallback("or", [leaf, Sleep("script", msec=300)]), clock=station.clock)
        tree.setup(**station.infrastructure)
        recorder = Recorder("test", 0)
        Run(RunRequest(TreeSource("test", "python")), tree, station).execute([recorder])
        (cycle,) = recorder.report().cycles
        assert cycle.status == "SUCCESS"
        shares.append(cycle.leaf_times["RunPolicy"])
    assert shares[0].share == pytest.approx(0.5, abs=0.03) and shares[1].share == 0.0
    assert "has not been halted" in shares[0].reasons[0]
    assert "not finite" in shares[1].reasons[0]


def test_a_policy_whose_process_is_killed_fails_and_acts_again(station, policy):
    acting = Acting(station, model=policy(np.zeros(7))).run(0.2)
    os.kill(policy_process.shared_process(ONNX.memory).pid, signal.SIGKILL)
    acting.run(0.2)
    assert acting.status is NodeStatus.FAILURE
    assert "ended its process (SIGKILL)" in acting.leaf.feedback_message
    acting.status = acting.tree.tick()
    assert acting.run(0.2).status is NodeStatus.RUNNING


def test_a_policy_goes_on_in_another_leaf(station, policy):
    """The state of a leaf, as in a snapshot, is enough for another one to act as it would."""
    model = policy(np.tile([[0.004], [-0.002]], (1, 7)) * [1, 1, 1, 0, 0, 0, -200])
    acting = Acting(station, model=model).run(0.27)
    states = acting.tree.get_state(), station.get_state()
    acting.run(0.5)
    other = Acting(station, model=model)
    station.set_state(states[1])
    other.tree.set_state(states[0])
    other.run(0.5)
    assert np.array_equal(np.array(acting.rows[-500:]), np.array(other.rows))


def test_the_command_refuses_files_of_strangers_in_time(tmp_path):
    """Exit code 2, below 1 GB; the seconds of the limit and of the start are not measured here."""
    path = tmp_path / "policy.onnx"
    path.write_bytes(onnx.product(40_000))
    command = "-m", "bt_manip", "run", "pick_place_policy", "--set", f"policy={path}"
    measured = [sys.executable, "-c", PEAK_MEMORY, sys.executable, *command]
    done = subprocess.run(measured, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("Error: ") and str(path) in done.stderr.replace("\n", "")
    assert int(done.stdout) < 1 << 20  # of the largest of its processes; nothing else is printed


def test_a_policy_observes_images(opengl, station, tmp_path):
    """With less light it sees a darker picture."""
    means = []
    for brightness in (1.0, 0.2):
        station.cell.override("light:key", brightness=brightness)
        path = tmp_path / f"{brightness}.onnx"
        path.write_bytes(onnx.bright("overview_rgb", 24, 32))
        acting = Acting(station, model=str(path)).run(0.01)
        kind, pixels = acting.leaf.get_state()["past"][-1]["overview_rgb"]
        assert np.shape(pixels) == (24, 32, 3) and np.dtype(kind) == np.uint8
        acting.tree.halt()
        means.append(np.mean(pixels))
    assert means[1] < 0.9 * means[0]


def test_without_opengl_a_policy_with_images_is_refused_before_the_run(
    station, policy, monkeypatch
):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with pytest.raises(NodeError, match="nothing can be drawn"):
        Acting(station, model=policy(np.zeros(7), {"overview_rgb": (24, 32, 3)}))


def test_a_history_begins_with_the_first_observation_and_moves_on(station, policy):
    first, *others = ({"x": np.array([float(i)])} for i in range(5))
    assert with_history([first, others[0]], 4)["x"].tolist() == [[0.0], [0.0], [0.0], [1.0]]
    assert with_history([first, *others], 3)["x"].tolist() == [[2.0], [3.0], [4.0]]
    assert with_history([first, *others], 1) is others[-1]
    tools, model = [], policy(np.zeros((2, 7)), {"robot_tool_position": (2, 3)}, history="2")
    acting = Acting(station, model=model)
    for _ in range(5):
        tools.append(station.robot.tool_pose.translation)
        acting.run(0.05)
    past = acting.leaf.get_state()["past"]
    assert [one.keys() for one in past] == [{"robot_tool_position"}] * 2
    seen = [one["robot_tool_position"][1] for one in past]
    np.testing.assert_allclose(seen, tools[-2:], atol=1e-6)  # one for each action


def test_states_go_on_from_action_to_action_and_leaf_to_leaf_and_begin_anew(station, tmp_path):
    path = tmp_path / "counting.onnx"
    path.write_bytes(onnx.counting())
    acting = Acting(station, model=str(path)).run(0.25)
    saved = json.loads(json.dumps(acting.leaf.get_state()))
    assert set(saved["states"]["state_n"][1]) == {5.0}
    other = RunPolicy("policy", model=str(path))
    other.set_state(saved)
    assert other.get_state() == saved
    acting.tree.halt()
    acting.tree.tick()
    assert set(acting.leaf.get_state()["states"]["state_n"][1]) == {1.0}
