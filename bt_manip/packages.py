"""Names in packages that may be missing, to tell users which one to install."""

import sys
from collections.abc import Iterable
from typing import Any

from bt_manip.exceptions import did_you_mean

PACKAGES: dict[str, dict[str, str]] = {
    "bt-manip-blocks": {
        "object": "coloured_block sorting_tray",
        "behaviour": "AreSorted AreStacked ChooseBase ChooseBlock FindSlot ScatterBlocks",
        "scene": "table_and_tray",
        "tree": "sort_blocks stack_blocks",
    },
    "bt-manip-btcpp3": {
        "dialect": "btcpp-3",
        "node of a dialect": (
            "BlackboardCheckBool BlackboardCheckDouble BlackboardCheckInt BlackboardCheckString "
            "SequenceStar"
        ),
    },
    "bt-manip-camera": {
        "command": "camera",
        "object": "april_tag depth_camera",
        "behaviour": (
            "DetectTags EstimatePose IsSeen LookAt SeeObjects SegmentTable WaitUntilSeen"
        ),
        "pose source": "seen",
        "scene": "table_and_tray_seen table_seen table_with_tag",
        "tree": "pick_place_seen sort_blocks_seen stack_blocks_seen",
        "fault": "camera_covered camera_delay camera_dropout camera_moved lights_out look_alike",
        "message source": "seen",
        "panel": "seen",
    },
    "bt-manip-contracts": {
        "command": "new",
        "module": (
            "bt_manip.testing.contracts bt_manip.testing.Example bt_manip.testing.contracts_of "
            "bt_manip.testing.DEVICE_CONTRACT bt_manip.testing.GRIPPER_CONTRACT "
            "bt_manip.testing.ROBOT_CONTRACT bt_manip.testing.RobotCase "
            "bt_manip.testing.holds_an_object bt_manip.testing.recovers_from_a_problem"
        ),
    },
    "bt-manip-convert": {"conversion": "python"},
    "bt-manip-everyday": {
        "object": "blue_can bowl coffee_mug green_can red_can yellow_can",
        "behaviour": "HoldsExactly ReadSentence",
        "scene": "cans_into_box mug_on_shelf",
        "tree": "cans_into_box mug_on_shelf",
    },
    "bt-manip-franka": {"backend": "franka"},
    "bt-manip-fuel": {
        "model source": "fuel http https",
        "model format": "sdf",
        "model cache": "fuel",
        "file": ".sdf .world model.config sdf",
    },
    "bt-manip-groot": {
        "option": "--groot --groot-port",
        "view": "groot",
        "recorder": "btlog db3",
        "export format": "btlog db3",
        "file": ".btlog .db3",
        "module": "bt_manip.groot",
    },
    "bt-manip-hands": {
        "robot": "ur5e_allegro",
        "gripper": "hand suction",
        "module": (
            "bt_manip.grippers.suction bt_manip.grippers.SuctionGripper "
            "bt_manip.grippers.suction_gripper"
        ),
    },
    "bt-manip-impedance": {
        "object": "drawer push_button",
        "controller": "cartesian_impedance joint_impedance",
        "behaviour": (
            "FindFreeEnd HoldOut Insert IsHandedOver IsInserted IsOpen IsReleased Press PullOpen "
            "ReachHandle WasPressed"
        ),
        "scene": "button_on_table hand_over open_drawer peg_in_hole peg_on_table press_button",
        "tree": "hand_over insert_peg open_drawer peg_in_hole press_button",
    },
    "bt-manip-learn": {
        "command": "demos",
        "controller": "native_pd",
        "pool": "ray",
        "gripper": "native_two_finger",
        "action kind": "cartesian_deltas joint_targets joint_torques subtree_choice",
        "contract": "environments",
        "hook": "register_actions",
        "kind of parts": "actions",
        "module": (
            "bt_manip.agents bt_manip.demonstrations bt_manip.envs bt_manip.control.NativePD "
            "bt_manip.grippers.NativeTwoFingerGripper bt_manip.evaluation.RayPool"
        ),
    },
    "bt-manip-mcp": {"command": "mcp", "recorder": "picture", "file": ".png"},
    "bt-manip-menagerie": {"robot": "fr3 iiwa14 menagerie_panda ur5e xarm7"},
    "bt-manip-moveit-pro": {
        "dialect": "moveit-pro",
        "robot": "gen3",
        "command": "objectives",
        "node of a dialect": (
            "AddCollisionBox AddCollisionMesh AddPoseStampedToVector AddURDF AttachURDF "
            "AveragePoseStampedVector BiasedCoinFlip BreakpointSubscriber CalculatePoseOffset "
            "CallTriggerService ClearSnapshot ComputeInverseKinematics "
            "ComputeLinkPoseForwardKinematics ConvertMtcSolutionToJointTrajectory "
            "CreatePoseStamped CreateRobotState CreateStringMessage CreateTwistStamped "
            "CreateWrenchStamped DetachURDF ExecuteMTCSolution ExecuteTrajectory ForEach "
            "ForEachUntilSuccess GenerateCoveragePath GeneratePointToPointTrajectory "
            "GetCurrentPlanningScene GetElementOfVector GetJointState GetSizeOfVector "
            "InitializeMTCTask InsertInVector IsAnyObjectAttached "
            "IsCollisionObjectInPlanningScene IsPoseNearIdentity IsUserAvailable "
            "ListControllers LoadPoseStampedFromYaml LoadPoseStampedVectorFromYaml LogMessage "
            "MoveGripperAction OverridePoseOrientation PlanCartesianPath PlanMTCTask "
            "PlanToJointGoal PublishEmpty PublishMarkers PublishString PublishTF "
            "PushBackVector ReadTextFileAsString RemoveFromVector RemoveURDFFromScene "
            "RepeatUnlessFailureEachTick RepeatUnlessFailureWithinTick ReplaceInVector "
            "ResetMujocoKeyframe ResetPlanningSceneObjects ResetPoseStampedVector ResetVector "
            "RetrieveWaypoint ReversePoseStampedVector SaveCurrentState SavePoseStampedToYaml "
            "SetAdmittanceParameters SetMujocoState SetupMTCBatchPoseIK "
            "SetupMTCCartesianMoveToRobotState SetupMTCConnectWithProRRT SetupMTCCurrentState "
            "SetupMTCFromSolution SetupMTCMoveAlongFrameAxis SetupMTCPathIK "
            "SetupMTCPlanToPose SetupMTCPlanToRobotState SetupMTCSetCollisionRule "
            "SplitMTCSolution StopwatchBegin StopwatchEnd SwitchController "
            "SwitchUIPrimaryView TransformPose TransformPoseFrame TransformPoseWithPose "
            "UnpackJointStateMessage UnpackPointMessage UnpackPoseMessage "
            "UnpackRobotStateMessage UnpackStringMessage UnpackTwistStampedMessage "
            "UnpackWrenchStampedMessage ValidateTrajectory VisualizeMesh VisualizePath "
            "VisualizePose WaitForDuration WaitForMTCSolutionApproval WaitForUserPathApproval "
            "WhichObjectIsAttached"
        ),
    },
    "bt-manip-nav2": {
        "behaviour": (
            "DistanceController GoalUpdatedController GoalUpdater NonblockingSequence "
            "PathLongerOnApproach PersistentSequence PipelineSequence RateController RecoveryNode "
            "RoundRobin SingleTrigger SpeedController"
        ),
        "dialect": "nav2",
    },
    "bt-manip-policy": {
        "behaviour": "IsAbove RunPolicy",
        "kind of policies": "onnx",
        "tree": "pick_place_policy",
        "hook": "register_policies",
        "kind of parts": "policies",
    },
    "bt-manip-recording": {
        "command": "export",
        "recorder": "mcap",
        "export format": "csv mcap npz parquet",
        "file": ".mcap",
        "hook": "register_export_formats register_message_sources",
        "kind of parts": "export_formats message_sources",
        "module": (
            "bt_manip.cell.CellScene bt_manip.cell.PLANE_THICKNESS bt_manip.cell.SceneCamera "
            "bt_manip.cell.SceneSource bt_manip.cell.TexturedMesh bt_manip.cell.Triangles "
            "bt_manip.cell.VisualShape bt_manip.arm.tool_path "
            "bt_manip.record.Continuation bt_manip.record.McapRecorder "
            "bt_manip.record.RecordedInterventions bt_manip.record.RecordedRun "
            "bt_manip.record.RecordedScene bt_manip.record.Recording bt_manip.record.Timeline "
            "bt_manip.record.running_leaves bt_manip.record.write_csv bt_manip.record.write_mcap "
            "bt_manip.record.write_parquet"
        ),
    },
    "bt-manip-roadmap": {"planner": "lazy_roadmap"},
    "bt-manip-setup": {
        "command": "robot robot-measure",
        "module": "bt_manip.robot_setup bt_manip.grippers.find_fingers",
    },
    "bt-manip-stress": {
        "command": "stress",
        "contract": "faults",
        "modifier": "fault",
        "hook": "register_faults",
        "kind of parts": "faults",
        "fault": (
            "container_vanishes exception heavy knock move obstacle push sensor_delay sensor_nan "
            "sensor_noise slippery stuck stuck_finger stuck_joint tick_delay torque_loss vanish"
        ),
        "module": (
            "bt_manip.faults bt_manip.evaluation.LEGEND bt_manip.evaluation.StressEpisode "
            "bt_manip.evaluation.StressPhase bt_manip.evaluation.StressResult "
            "bt_manip.evaluation.StressTable bt_manip.evaluation.StressTester "
            "bt_manip.evaluation.lost_stress bt_manip.evaluation.plan_episodes"
        ),
    },
    "bt-manip-trossen": {"backend": "trossen", "robot": "widowx_ai"},
    "bt-manip-view": {
        "option": "--view --view-port --view-breakpoints",
        "command": "view replay report",
        "view": "view",
        "hook": "register_panels",
        "kind of parts": "panels",
        "panel": "blackboard camera log node overlays plots pull results timeline tree",
        "recorder": "video",
        "export format": "mp4 gif",
        "file": ".mp4 .gif",
        "module": (
            "bt_manip.viewer.page bt_manip.viewer.html bt_manip.record.video "
            "bt_manip.viewer.Page bt_manip.viewer.Panel bt_manip.viewer.ReplayPage "
            "bt_manip.record.VideoRecorder bt_manip.record.write_video "
            "bt_manip.evaluation.results_page"
        ),
    },
}
"""By package and kind: names separated by blanks.

Kinds of parts are those of `bt_manip.registry.Registry`. Files are known by suffix, whole
name or root element; modules are those that were part of ``bt_manip``.
"""

REQUIRED = {
    "bt-manip-policy": "bt-manip-learn",
    "bt-manip-setup": "bt-manip-contracts",
    "bt-manip-view": "bt-manip-recording",
}
"""For packages that require another one of `PACKAGES`: its name."""


def missing(kind: str | None, name: str) -> str:
    """Return the end of an error message: the package of an unknown name, and its installation.

    Args:
        kind: A kind of `PACKAGES`; None for any.
        name: The name.

    Returns:
        ``"needs the package ..."``, or an empty string if no package has it.
    """
    for package, kinds in PACKAGES.items():
        names = " ".join(kinds.values()) if kind is None else kinds.get(kind, "")
        if name in names.split():
            both = (REQUIRED.get(package), package)
            folders = " ".join(f"./plugins/{each}" for each in both if each)
            return f"needs the package {package}: pip install {folders} (in a clone)"
    return ""


def suggestion(kind: str | None, name: str, valid: Iterable[str]) -> str:
    """Return the package of an unknown name, or the nearest valid names, for an error message.

    Args:
        kind: A kind of `PACKAGES`; None for any.
        name: The unknown name.
        valid: The known names.

    Returns:
        ``"; it needs the package ..."``, or what `did_you_mean` returns.
    """
    package = missing(kind, name)
    return f"; it {package}" if package else did_you_mean(name, valid)


class MovedModules:
    """Finder of modules that names the package into which one has moved."""

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> None:
        """Find nothing; raise an ImportError for a module, or a name in one, that has moved."""
        for package, kinds in PACKAGES.items():
            if name in kinds.get("module", "").split():
                root, last = package.replace("-", "_"), name.rpartition(".")[2]
                same = last.endswith(root.rpartition("_")[2])  # such as robot_setup
                new = root if same else f"{root}.{last}"
                problem = f"{name} is now {new}, and {missing('module', name)}"
                raise ModuleNotFoundError(problem, name=name)


def name_moved_modules() -> None:
    """Let imports of modules that have moved name their packages."""
    sys.meta_path.append(MovedModules)
