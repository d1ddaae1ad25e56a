"""Leaves that make poses and lists, read files and keep the planning scene."""

import math

import numpy as np
import pytest

from bt_manip.bt import Sequence, Status, Tree
from bt_manip_moveit_pro import interface, planning_scene, poses, vectors
from bt_manip_moveit_pro.values import JointState, PoseStamped

HALF = math.sqrt(0.5)


def run(*leaves, **entries):
    """Tick leaves once, in a sequence; give the tree."""
    tree = Tree(Sequence(list(leaves)))
    for name, value in entries.items():
        tree.blackboard[name] = value
    tree.tick()
    return tree


TURNED = (0.0, 0.0, HALF, HALF)  # x points along y
ENTRIES = {
    "turned": PoseStamped("world", (1.0, 0.0, 0.0), TURNED),
    "camera": PoseStamped("camera", (0.0, 0.0, 1.0), TURNED),
    "seen": PoseStamped("object", (1.0, 0.0, 0.0)),
    "several": [
        PoseStamped("world", (i, 0.0, 0.0), (0.0, 0.0, sign * math.sin(a), sign * math.cos(a)))
        for i, a, sign in ((0.0, 0.1, 1.0), (1.0, 0.3, -1.0))
    ],
}


@pytest.mark.parametrize(
    ("leaf", "expected"),
    [
        (
            poses.CreatePoseStamped(
                reference_frame="base_link",
                position_xyz="0.1; 0.2;-0.3",
                orientation_xyzw=f"0;0;{HALF}; {HALF}",
                pose_stamped="{found}",
            ),
            PoseStamped("base_link", (0.1, 0.2, -0.3), TURNED),
        ),
        (
            poses.TransformPose(
                input_pose="{turned}", translation_xyz="0.5;0;0", output_pose="{found}"
            ),
            PoseStamped("world", (1.0, 0.5, 0.0), TURNED),
        ),
        (
            poses.TransformPoseWithPose(
                input_pose="{seen}", transform_pose="{camera}", output_pose="{found}"
            ),
            PoseStamped("camera", (0.0, 1.0, 1.0), TURNED),
        ),
        (
            poses.AveragePoseStampedVector(
                pose_stamped_vector="{several}", average_pose_stamped="{found}"
            ),
            PoseStamped("world", (0.5, 0.0, 0.0), (0.0, 0.0, math.sin(0.2), math.cos(0.2))),
        ),
    ],
    ids=["from texts", "along its own axes", "by another one", "an average, whatever the signs"],
)
def test_a_pose_is_made_of_others(leaf, expected):
    found = run(leaf, **ENTRIES).blackboard["found"]
    assert found.frame == expected.frame
    np.testing.assert_allclose(found.T.homogeneous, expected.T.homogeneous, atol=1e-12)


@pytest.mark.parametrize("frames", [(), ("world", "camera")])
def test_only_poses_of_one_frame_have_an_average(frames):
    leaf = poses.AveragePoseStampedVector(pose_stamped_vector="{p}", average_pose_stamped="{q}")
    tree = run(leaf, p=[PoseStamped(frame) for frame in frames])
    assert tree.failure_reason().endswith("poses of one frame are averaged, at least one")


def test_a_position_has_three_numbers():
    tree = run(poses.CreatePoseStamped(position_xyz="0;0", pose_stamped="{pose}"))
    assert tree.root.status is Status.FAILURE
    assert "3 numbers" in tree.failure_reason()


@pytest.mark.parametrize(
    ("x", "angle", "near"), [(0.009, 0.009, 1), (0.0, -0.011, 0), (-0.011, 0.0, 0)]
)
def test_a_pose_is_compared_with_the_identity(x, angle, near):
    pose = PoseStamped("world", (x, 0, 0), (0, 0, math.sin(angle / 2), math.cos(angle / 2)))
    leaf = poses.IsPoseNearIdentity(pose="{p}")
    assert run(leaf, p=pose).root.status is (Status.SUCCESS if near else Status.FAILURE)


def test_frames_that_are_in_each_other_are_refused():
    leaves = [
        poses.PublishTF(pose=f"{{{p}}}", child_frame_id=f) for p, f in (("p", "a"), ("q", "b"))
    ]
    tree = run(*leaves, p=PoseStamped("b", (0, 0, 1)), q=PoseStamped("a", (0, 0, 1)))
    assert tree.failure_reason().endswith("the pose of 'b' is in its own frame")


def test_a_coverage_path_goes_back_and_forth_in_lanes():
    leaf = poses.GenerateCoveragePath(
        bottom_right_corner="{c}", width="0.5", height="0.3", stride_distance="0.1",
        vector_of_poses="{path}",
    )  # fmt: skip
    turned = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))  # x and y of the corner are y and -x
    path = run(leaf, c=PoseStamped("base", (1.0, 2.0, 0.3), turned)).blackboard["path"]
    expected = np.column_stack([[1.0, 0.5, 0.5, 1.0] * 2, np.repeat([2.0, 2.1, 2.2, 2.3], 2)])
    np.testing.assert_allclose([one.position for one in path], [(*p, 0.3) for p in expected])
    np.testing.assert_allclose([one.orientation for one in path], [turned] * 8, atol=1e-12)
    assert {one.frame for one in path} == {"base"}


def test_lists_are_changed_as_copies():
    tree = run(
        vectors.ResetVector(vector="{v}"),
        vectors.PushBackVector(input_vector="{v}", element="a", output_vector="{v}"),
        vectors.PushBackVector(input_vector="{v}", element="c", output_vector="{v}"),
        vectors.InsertInVector(input_vector="{v}", element="b", index="1", output_vector="{w}"),
        vectors.ReplaceInVector(input_vector="{w}", element="x", index="0", output_vector="{r}"),
        vectors.RemoveFromVector(input_vector="{w}", index="0", output_vector="{s}"),
        vectors.ReversePoseStampedVector(input_vector="{w}", output_vector="{t}"),
        vectors.GetElementOfVector(vector_in="{w}", index="2", element="{last}"),
        vectors.GetSizeOfVector(vector_in="{w}", vector_size="{n}"),
    )
    assert tree.root.status is Status.SUCCESS, tree.failure_reason()
    entries = tree.blackboard
    assert (entries["v"], entries["w"], entries["r"]) == (["a", "c"], ["a", "b", "c"], [*"xbc"])
    assert (entries["s"], entries["t"]) == (["b", "c"], ["c", "b", "a"])
    assert (entries["last"], entries["n"]) == ("c", 3)


@pytest.mark.parametrize(
    "leaf",
    [
        vectors.GetElementOfVector(vector_in="{v}", index="1", element="{e}"),
        vectors.RemoveFromVector(input_vector="{v}", index="-1", output_vector="{v}"),
        vectors.InsertInVector(input_vector="{v}", element="b", index="3", output_vector="{v}"),
        vectors.GetSizeOfVector(vector_in="{missing}", vector_size="{n}"),
        interface.LoadPoseStampedFromYaml(file_path="nothing.yaml", output="{one}"),
    ],
    ids=lambda leaf: leaf.name,
)
def test_a_missing_item_list_or_file_is_a_failure_with_a_reason(leaf):
    tree = run(leaf, v=["a"])
    assert tree.root.status is Status.FAILURE
    assert tree.failure_reason()


def test_poses_are_written_to_a_file_and_read_again(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first = PoseStamped("tool", (0.1, 0.2, 0.3))
    second = PoseStamped("world", (1, 2, 3), (1, 0, 0, 0))
    tree = run(
        interface.SavePoseStampedToYaml(message="{a}", yaml_filename="poses", overwrite="true"),
        interface.SavePoseStampedToYaml(message="{b}", yaml_filename="poses", overwrite="false"),
        interface.LoadPoseStampedVectorFromYaml(file_path="poses.yaml", output="{both}"),
        interface.LoadPoseStampedFromYaml(file_path="poses.yaml", output="{one}"),
        a=first, b=second,
    )  # fmt: skip
    assert tree.root.status is Status.SUCCESS, tree.failure_reason()
    assert tree.blackboard["both"] == [first, second]
    assert tree.blackboard["one"] == first


def test_the_planning_scene_knows_what_is_attached():
    tree = run(
        planning_scene.AddURDF(urdf_name="part"),
        planning_scene.AddCollisionBox(object_id="wall"),
        planning_scene.AttachURDF(urdf_name="part", parent_link_name="tool0"),
        planning_scene.IsAnyObjectAttached(),
        planning_scene.WhichObjectIsAttached(object_name="{name}"),
        planning_scene.DetachURDF(urdf_name="part"),
        planning_scene.RemoveURDFFromScene(urdf_name="part"),
        planning_scene.IsCollisionObjectInPlanningScene(collision_object_name="wall"),
        planning_scene.IsAnyObjectAttached(),
    )
    assert tree.blackboard["name"] == "part"
    assert tree.failure_reason().endswith("no object is attached")


@pytest.mark.parametrize(
    ("names", "joints", "found"),
    [
        (["rail", "joint1", "joint2"], ["joint1", "joint2"], (1.0, 2.0)),
        (["fr3_finger_joint1", "fr3_joint1", "fr3_joint2"], ["joint1", "joint2"], (1.0, 2.0)),
        (["r_j1", "r_j2", "l_j1", "l_j2"], ["j1", "j2"], (2.0, 3.0)),
    ],
    ids=["joints of a rail", "a prefix and a finger", "two arms, of which the hint selects one"],
)
def test_joints_of_others_are_left_out(names, joints, found):
    state = JointState({name: float(i) for i, name in enumerate(names)})
    assert state.configuration(joints, "l") == found


@pytest.mark.parametrize("names", [["joint1"], ["r_j1", "r_j2", "x_j1", "x_j2"]])
def test_a_joint_state_of_other_joints_is_refused(names):
    state = JointState(dict.fromkeys(names, 0.0))
    with pytest.raises(ValueError, match="not of the joints"):
        state.configuration(["j1", "j2"], "l")
