"""Objectives of PickNik's public example workspace: which are complete, run, and move something."""

from pathlib import Path

import numpy as np
import pytest

from bt_manip.bt import read_tree
from bt_manip.runner import RunLoop, RunRequest, find_tree, known_behaviours, prepare
from bt_manip_moveit_pro.objectives import robot_of, run_objective, summary, survey

SCENES = Path(__file__).parent / "scenes"
MOCK_SIM = "moveit_pro_ur_configs/mock_sim/objectives"


def test_an_objective_is_recognised_and_what_it_lacks_is_named(workspace):
    results = list(survey(workspace, run=False, only="kitchen_sim"))
    lacks = {result.path.stem: result.lacks for result in results}
    missing = ("GetImage", "GetMasks2DFromExemplar", "PublishMask2D")
    assert (lacks["write_text"], lacks["segment_image_from_prompt"]) == ((), missing)
    assert summary(results) == "7 of 13 objectives have all leaves and sub-trees."
    registry = known_behaviours(workspace.parts)
    for result in results:
        path = workspace.root / result.path
        reading = read_tree(path, registry, dialect="auto", library=True, strict=False)
        assert "ForEach" in reading.registry, path


@pytest.mark.soak
def test_142_of_296_objectives_are_complete(workspace):
    results = list(survey(workspace, run=False))
    assert summary(results) == "142 of 296 objectives have all leaves and sub-trees."


@pytest.mark.parametrize(
    ("joints", "robot"),
    [
        (["linear_rail_joint", "pan", "lift"], "a"),
        (["left_joint1", "left_joint2", "right_joint1", "right_joint2"], "b"),
        (["joint1"], ""),
    ],
)
def test_the_robot_is_the_first_whose_joints_the_waypoints_name(joints, robot):
    arms = {"a": ["pan", "lift"], "b": ["joint1", "joint2"]}
    assert robot_of({"Home": dict.fromkeys(joints, 0.0)}, arms) == robot


@pytest.mark.parametrize(
    ("name", "robot", "outcome"),
    [
        ("lab_sim/objectives/joint_diagnostic.xml", "ur5e", "2 rounds"),
        ("moveit_pro_kinova_configs/kinova_sim/objectives/write_picknik.xml", "gen3", "SUCCESS"),
        ("kitchen_sim/objectives/move_away.xml", "panda", "SUCCESS"),
    ],
)
def test_an_objective_runs_to_its_end(name, robot, outcome, workspace, menagerie):
    result = run_objective(workspace.root / name, robot, workspace)
    assert (result.outcome, result.travelled) == (outcome, True)


def until(run, condition, seconds):
    """Run until a condition holds, for a simulated time at most."""
    clock = run.station.cell
    run.execute(stop=lambda: condition() or clock.time > seconds)
    assert condition()


def begin(name, scene, workspace, folder=None):
    """Prepare a run of an objective, or of a tree with the sub-trees of a folder, in a scene."""
    path = workspace.root / name
    folder = path.parent if folder is None else workspace.root / folder
    request = RunRequest(
        find_tree(str(path), {}), robot="ur5e", scene=str(SCENES / scene),
        configurations=workspace.waypoints(folder), reading=workspace.reading(folder),
    )  # fmt: skip
    return prepare(request, workspace.parts)


def test_a_cube_is_carried_and_rests_where_the_waypoint_places_it(workspace, menagerie):
    run = begin("lab_sim/objectives/3_waypoint_pick_and_place.xml", "lab.toml", workspace)
    cell, gripper = run.station.cell, run.station.gripper

    def rests():
        slow = abs(cell.velocity("cube")).max() < 0.01
        free = gripper.is_open and "cube" not in gripper.held
        return slow and free and "right" in cell.contacts.partners("cube")

    until(run, rests, 20.0)
    offset = cell.pose("cube").translation - cell.pose("right").translation
    assert abs(offset[:2]).max() < 0.02 and 0.02 < offset[2] < 0.05


def test_a_cube_is_carried_from_the_right_to_the_left(workspace, menagerie):
    run = begin(f"{MOCK_SIM}/constrained_pick_place.xml", "machine.toml", workspace)
    cell, robot = run.station.cell, run.station.robot
    start = cell.pose("cube").translation.copy()
    until(run, lambda: cell.pose("cube").translation[1] < -0.7 and run.station.arm.at_rest, 10.0)
    assert run.station.gripper.held == ("cube",)
    assert np.linalg.norm(cell.pose("cube").translation - robot.tool_pose.translation) < 0.02
    assert np.linalg.norm(cell.pose("cube").translation - start) > 1.0


PICK = """<root BTCPP_format="4" main_tree_to_execute="Carry">
  <BehaviorTree ID="Carry">
    <Sequence>
      <SubTree ID="Open Gripper"/>
      <Action ID="CreatePoseStamped" reference_frame="cube" orientation_xyzw="1;0;0;0"
          pose_stamped="{grasp}"/>
      <SubTree ID="Pick from Pose" grasp_pose="{grasp}" approach_distance="0.1"
          retract_xyz="0;0;-0.1"/>
      <Action ID="CreatePoseStamped" reference_frame="right" position_xyz="0;0;0.035"
          orientation_xyzw="1;0;0;0" pose_stamped="{place}"/>
      <SubTree ID="Place at Pose" place_pose="{place}" approach_distance="0.1"
          retract_xyz="0;0;-0.1"/>
    </Sequence>
  </BehaviorTree>
</root>"""


def test_sub_trees_of_the_task_constructor_pick_and_place_a_cube(workspace, menagerie, tmp_path):
    (tmp_path / "carry.xml").write_text(PICK)
    run = begin(tmp_path / "carry.xml", "lab.toml", workspace, "lab_sim/objectives")
    with RunLoop(run) as loop:
        ended = loop.cycle()
    assert ended.succeeded, ended.reason
    cell = run.station.cell
    offset = cell.pose("cube").translation - cell.pose("right").translation
    assert abs(offset[:2]).max() < 0.01
    assert cell.contacts.partners("cube") == ["right"]


@pytest.mark.soak
def test_at_least_12_objectives_that_move_an_arm_run_to_their_end(workspace, menagerie):
    results = list(survey(workspace, run=True))
    ended = [r for r in results if r.outcome == "SUCCESS" or r.outcome.endswith("rounds")]
    assert sum(result.travelled for result in ended) >= 12
