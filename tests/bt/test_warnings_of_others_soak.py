"""Warnings of trees of others: those of a sample are as judged by hand, and no others come."""

import random
from dataclasses import replace
from pathlib import Path

import pytest

from bt_manip.bt import Stubs, read_tree
from bt_manip.plugins import load_plugins
from bt_manip.runner import known_behaviours

SHARED = Path(__file__).resolve().parents[3] / "shared"
SEED, COUNT = 8, 60
PRO, CORPUS = "moveit_pro/src/", "btcpp/corpus/"
CORE = "MoveIt Pro's core has a tree of that name; the workspace's only one, which is read, uses "

JUDGED = {
    f"{PRO}dual_arm_sim/objectives/teleoperate.xml:9:7": f"{CORE}'controllers'",
    f"{PRO}dual_arm_sim/objectives/teleoperate.xml:10:7": f"{CORE}'controllers'",
    f"{PRO}dual_arm_sim/objectives/teleoperate.xml:11:7": f"{CORE}no 'execution_pipeline'",
    f"{PRO}hangar_sim/objectives/request_teleoperation.xml:144:23": f"{CORE}no 'seed'",
    f"{PRO}hangar_sim/objectives/request_teleoperation.xml:145:23": (
        f"{CORE}no 'execution_pipeline'"
    ),
    f"{PRO}hangar_sim/objectives/wait_for_trajectory_approval_if_user_available.xml:16:19": (
        "it is a sub-tree (runnable is false) whose model declares no port: run alone, it fails"
    ),
    f"{PRO}lab_sim/objectives/place_at_pose_with_approval.xml:59:9": (
        "both trees of that name write the links themselves, and no {cartesian_path_links}"
    ),
    f"{PRO}moveit_pro_kinova_configs/space_satellite_sim_camera_cal/objectives/"
    "calibrate_camera_at_waypoint_-_tag_tfs.xml:42:15": (
        "the sub-tree, which reads transforms, has no 'parameters'"
    ),
    f"{CORPUS}cond_condition_node_skip.xml:3:56": "_skipIf is the constant true",
    f"{CORPUS}ctl_switch2_numeric_enum.xml:11:41": "no entry 'nope': the default case is tested",
    f"{CORPUS}doc_redefined_tree.xml:3:17": "the tree is defined twice",
    f"{CORPUS}sub_precondition_scope.xml:8:40": "'inner' is written in the sub-tree, not read",
}
"""Places of the warnings of the sample, each with the reason for which it is true."""


@pytest.mark.soak
def test_the_warnings_of_sixty_trees_of_others_are_those_judged_true():
    workspaces = pytest.importorskip("bt_manip_moveit_pro.objectives")
    pytest.importorskip("bt_manip_nav2")
    if not (SHARED / "nav2").is_dir():
        pytest.skip(f"no trees of others at {SHARED}")
    parts = load_plugins().parts
    workspace = workspaces.Workspace(SHARED / "moveit_pro" / "src", parts)
    homes = {path: home for home in workspace.folders for path in workspace.objectives(home)}
    nav2 = sorted(SHARED.glob("nav2/nav2_bt_navigator/behavior_trees/*.xml"))
    engine = sorted(
        path for path in (SHARED / "btcpp").rglob("*.xml") if b"<BehaviorTree" in path.read_bytes()
    )
    registry, found = known_behaviours(parts), set()
    models = Stubs(models=list(SHARED.glob("nav2/**/nav2_tree_nodes.xml")))
    for path in random.Random(SEED).sample([*homes, *nav2, *engine], COUNT):
        if path in homes:
            options = replace(
                workspace.reading(homes[path]), strict=True, stubs=Stubs(unknown=True)
            )
            reading = read_tree(path, registry, options)
        else:
            stubs = models if path in nav2 else Stubs(unknown=True)
            reading = read_tree(path, registry, dialect="auto", stubs=stubs)
        found |= {str(warning.place).removeprefix(f"{SHARED}/") for warning in reading.warnings}
    assert found == set(JUDGED)
