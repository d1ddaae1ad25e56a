"""Leaves that plan and execute, on the Panda."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import build_station
from bt_manip.bt import Sequence, Status, Tree
from bt_manip.runner import RunLoop
from bt_manip_moveit_pro import motions, poses, task_constructor, vectors, without_effect
from bt_manip_moveit_pro.motions import ExecuteTrajectory, line
from bt_manip_moveit_pro.objectives import SCENE
from bt_manip_moveit_pro.task_constructor import Task
from bt_manip_moveit_pro.values import JointState, Motion, Plan, PoseStamped

READY = {f"panda_joint{i + 1}": q for i, q in enumerate((0.3, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8))}


@pytest.fixture(scope="module")
def panda():
    """Give a Panda alone in a cell, with a waypoint."""
    station = build_station(robot="panda", scene=str(SCENE))
    station.robot.configurations["Ready"] = {**READY, "linear_rail_joint": 3.0}
    return station


@pytest.fixture
def station(panda):
    """Give the Panda as it is at the start of a cycle."""
    with RunLoop(panda.resting()) as loop:
        loop.cycle()
    return panda


@pytest.fixture
def run(station):
    """Run leaves in a sequence until they complete, by default with success; give the tree."""

    def go(*leaves, status=Status.SUCCESS, timeout=20.0, **entries):
        tree = Tree(Sequence(list(leaves)), clock=lambda: station.cell.time)
        for name, value in entries.items():
            tree.blackboard[name] = value
        station.run(tree, timeout=timeout)
        assert tree.root.status is status, tree.failure_reason()
        return tree

    return go


def tool(station):
    return station.arm.model.pose(station.arm.q)


def test_a_waypoint_is_reached_without_the_joint_of_a_rail(station, run):
    run(
        motions.RetrieveWaypoint(waypoint_name="Ready", waypoint_joint_state="{state}"),
        motions.PlanToJointGoal(joint_goal="{state}"),
        ExecuteTrajectory(),
    )
    np.testing.assert_allclose(station.arm.q, list(READY.values()), atol=1e-9)
    np.testing.assert_allclose(station.robot.q, list(READY.values()), atol=5e-3)


UNREACHABLE = {
    "did you mean 'Ready'": [
        motions.RetrieveWaypoint(waypoint_name="Reddy", waypoint_joint_state="{s}")
    ],
    "joint": [motions.PlanToJointGoal(joint_goal="{beyond}")],
    "there is no frame 'no'": [
        poses.TransformPoseFrame(input_pose="{pose}", target_frame_id="no", output_pose="{q}")
    ],
    "can be followed up to": [motions.PlanCartesianPath(path="{path}")],
    "out of reach": [
        task_constructor.SetupMTCPlanToPose(task="{task}", target_pose="{far}"),
        task_constructor.PlanMTCTask(task="{task}", solution="{s}"),
    ],
}


@pytest.mark.parametrize(("reason", "leaves"), UNREACHABLE.items(), ids=UNREACHABLE)
def test_what_cannot_be_reached_fails_with_a_reason(run, reason, leaves):
    tree = run(
        *leaves,
        beyond=JointState({**READY, "panda_joint4": 1.0}),
        pose=PoseStamped(),
        path=[PoseStamped("grasp_link", (0, y, 0)) for y in (0.0, 0.1, 1.5)],
        far=PoseStamped("base_link", (3.0, 0.0, 0.5)),
        task=Task(),
        status=Status.FAILURE,
    )
    assert reason in tree.failure_reason()


def test_frames_are_those_of_the_tool_the_base_the_world_and_published_ones(station, run):
    into = poses.TransformPoseFrame
    tree = run(
        poses.PublishTF(pose="{pose}", child_frame_id="plane"),
        into(input_pose="{on}", target_frame_id="world", output_pose="{a}"),
        into(input_pose="{tip}", target_frame_id="base_link", output_pose="{b}"),
        pose=PoseStamped("base_link", (0.5, 0.0, 0.1)),
        on=PoseStamped("plane", (0.0, 0.1, 0.0)),
        tip=PoseStamped("grasp_link", (0.0, 0.0, 0.0)),
    )  # fmt: skip
    base = station.cell.pose("panda")
    on_plane = base.act(np.array([0.5, 0.1, 0.1]))
    np.testing.assert_allclose(tree.blackboard["a"].T.translation, on_plane, atol=1e-9)
    in_base = base.actInv(tool(station))
    np.testing.assert_allclose(tree.blackboard["b"].T.homogeneous, in_base.homogeneous, atol=1e-4)


def square(side=0.1):
    corners = [(0, 0, 0), (0, side, 0), (0, side, -side), (0, 0, -side), (0, 0, 0)]
    return [PoseStamped("grasp_link", corner) for corner in corners]


def test_a_cartesian_path_passes_its_poses_on_lines(station, run):
    start = tool(station)
    positions = []
    tree = run(
        motions.PlanCartesianPath(path="{path}", blending_radius="0.0"),
        path=square(),
    )
    plan = tree.blackboard["joint_trajectory_msg"]
    assert [bool(motion.q) for motion in plan.motions] == [True, False]
    lift = [PoseStamped("grasp_link", (0, 0, -0.05))]
    (line_up,) = (
        run(motions.PlanCartesianPath(path="{p}"), p=lift)
        .blackboard["joint_trajectory_msg"]
        .motions
    )
    assert len(line_up.path) == 1
    tree = Tree(ExecuteTrajectory(), clock=lambda: station.cell.time)
    tree.blackboard["joint_trajectory_msg"] = plan
    tree.setup(**station.infrastructure)

    def ended():
        positions.append(tool(station).translation.copy())
        return tree.tick_exactly_once().name != "RUNNING"

    station.step_until(ended, steps=10)
    assert tree.root.status is Status.SUCCESS, tree.failure_reason()
    for pose in square():
        corner = (start * pose.T).translation
        assert np.linalg.norm(np.array(positions) - corner, axis=1).min() < 2e-3
    plane = (np.array(positions) - start.translation) @ start.rotation[:, 0]
    assert abs(plane).max() < 2e-3


@pytest.mark.parametrize(
    ("length", "angle", "steps"), [(0.1, 0.05, 5), (0.101, 0.05, 6), (0.01, 0.31, 4), (0.0, 0.0, 1)]
)
def test_a_line_has_steps_of_2_cm_and_a_tenth_of_a_radian(length, angle, steps):
    end = pin.SE3(pin.rpy.rpyToMatrix(0, 0, angle), np.array([length, 0.0, 0.0]))
    samples = line(pin.SE3.Identity(), end)
    assert len(samples) == steps
    assert samples[-1].isApprox(end)


def test_stages_become_motions_the_approach_before_the_pose(station, run):
    """The poses are the end of the straight stage; the connecting stage moves to its start."""
    here = tool(station)
    goal = PoseStamped("grasp_link", (0.0, 0.1, 0.1))
    tree = run(
        task_constructor.InitializeMTCTask(task="{t}"),
        without_effect.SetupMTCCurrentState(task="{t}"),
        task_constructor.SetupMTCConnectWithProRRT(task="{t}"),
        task_constructor.SetupMTCMoveAlongFrameAxis(
            task="{t}", axis_frame="grasp_link", hand_frame="grasp_link", axis_z="1",
            min_distance="0.1", max_distance="0.1",
        ),
        vectors.ResetVector(vector="{v}"),
        vectors.PushBackVector(input_vector="{v}", element="{goal}", output_vector="{v}"),
        task_constructor.SetupMTCBatchPoseIK(task="{t}", target_poses="{v}"),
        task_constructor.PlanMTCTask(task="{t}", solution="{s}"),
        task_constructor.ExecuteMTCSolution(solution="{s}"),
        goal=goal,
    )  # fmt: skip
    end = here * goal.T
    np.testing.assert_allclose(tool(station).homogeneous, end.homogeneous, atol=2e-3)
    first, straight = tree.blackboard["s"].motions
    before = end * pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.1]))
    np.testing.assert_allclose(first.pose.homogeneous, before.homogeneous, atol=1e-3)
    assert first.approach == pytest.approx(0.1)
    assert straight.path


def test_stages_along_axes_of_the_world_follow_each_other(station, run):
    here = tool(station)
    sides = [("1", "0"), ("0", "1"), ("-1", "0")]
    tree = run(
        task_constructor.InitializeMTCTask(task="{t}"),
        *(
            task_constructor.SetupMTCMoveAlongFrameAxis(
                task="{t}", axis_frame="world", axis_x=x, axis_y=y, axis_z="0",
                min_distance="0.05", max_distance="0.05",
            )
            for x, y in sides
        ),
        task_constructor.PlanMTCTask(task="{t}", solution="{s}"),
        task_constructor.ExecuteMTCSolution(solution="{s}"),
    )  # fmt: skip
    found = {(one.speed, one.approach, one.blend) for one in tree.blackboard["s"].motions}
    assert found == {(1.0, 0.0, 0.0)}
    moved = tool(station).translation - here.translation
    np.testing.assert_allclose(moved, (0.0, 0.05, 0.0), atol=2e-3)


def test_the_gripper_closes_and_opens_by_its_position(station, run):
    for hand, closed, opened in (("franka", "0.019", "0.021"), ("robotiq", "0.11", "0.09")):
        action = f"/{hand}_gripper_controller/gripper_cmd"
        for position in (closed, opened):
            leaf = motions.MoveGripperAction(gripper_command_action_name=action, position=position)
            run(leaf)
            assert station.gripper.is_open is (position == opened)
            assert station.gripper.closed_on_nothing is (position == closed)


def test_a_halted_plan_stops_the_arm(station):
    tree = Tree(ExecuteTrajectory(), clock=lambda: station.cell.time)
    tree.blackboard["joint_trajectory_msg"] = Plan((Motion(q=tuple(READY.values()), speed=0.2),))
    tree.setup(**station.infrastructure)
    tree.tick_exactly_once()
    later = station.cell.time + 0.2
    station.step_until(lambda: station.cell.time >= later)
    assert station.arm.moving
    tree.halt()
    station.step_until(lambda: station.arm.at_rest)
    assert abs(station.arm.q - np.array(list(READY.values()))).max() > 0.05


def test_a_pose_is_reached_at_the_asked_speed(run):
    tree = run(
        task_constructor.SetupMTCPlanToPose(
            task="{t}", target_pose="{near}", velocity_scale_factor="0.5"
        ),
        task_constructor.PlanMTCTask(task="{t}", solution="{s}"),
        t=Task(), near=PoseStamped("grasp_link", (0.0, 0.0, -0.05)),
    )  # fmt: skip
    (motion,) = tree.blackboard["s"].motions
    assert (motion.speed, motion.approach, motion.blend) == (0.5, 0.0, 0.0)
