"""Public API: the names that users and plugin authors may import, and which of them are stable.

``python tools/api_page.py`` prints them with the first lines of their docstrings, as on the site.
"""

import importlib
import inspect

STABLE = {
    "bt_manip": "__version__ build_station hookimpl load_plugins load_tree",
    "bt_manip.exceptions": (
        "BtManipError TreeError UnknownBehaviourError PortError BlackboardError ScriptError "
        "MotionError NodeError did_you_mean"
    ),
    "bt_manip.spatial": "pose pointing_down",
    "bt_manip.bt": (
        "Tree load_tree parse_tree tree_to_xml BehaviourRegistry Blackboard Status NodeStatus "
        "Action SyncAction Condition Control Decorator SubTree Input Output InOut "
        "Sequence SequenceWithMemory AsyncSequence ReactiveSequence "
        "Fallback AsyncFallback ReactiveFallback Parallel ParallelAll IfThenElse WhileDoElse "
        "Switch2 Switch3 Switch4 Switch5 Switch6 TryCatch "
        "Inverter ForceSuccess ForceFailure KeepRunningUntilFailure Repeat RetryUntilSuccessful "
        "RunOnce Delay Timeout Precondition SkipUnlessUpdated WaitValueUpdate "
        "LoopBool LoopDouble LoopInt LoopString "
        "AlwaysSuccess AlwaysFailure Script ScriptCondition SetBlackboard UnsetBlackboard "
        "WasEntryUpdated Sleep Comment as_written TreeWatch"
    ),
    "bt_manip.behaviours": (
        "CellBehaviour ArmBehaviour MotionBehaviour RobotCondition "
        "SpawnObject RemoveObject ObjectExists IsIn IsOn Hover Reach Grasp Lift Drop PlaceOn "
        "PlaceAt IsHolding IsAt OpenGripper CloseGripper MoveToPose MoveToConfiguration MoveHome "
        "MoveLinear MoveThrough MoveArc Approach Retreat BackOff FollowTarget Stop SetSpeed "
        "SwitchController WaitUntilAtRest WaitUntilUndisturbed "
        "pose_to_text pose_from_text pose_input poses_input poses_output "
        "centre_pose bottom_pose top_grasp_poses downward_poses nearest_orientation yaw_of "
        "payload_of extent"
    ),
    "bt_manip.cell": (
        "Cell CellError OverlapError PhysicsDiverged Region Camera looking_at at_rest is_in is_on"
    ),
    "bt_manip.cell.objects": (
        "Prop ModelObject Cube Box Cylinder Sphere Capsule ConvexMesh Block Bottle Can Mug Peg "
        "HoleBoard Basket Bin Tray Table Shelf Wall RedBlock GreenBlock BlueBlock YellowBlock"
    ),
    "bt_manip.robots": (
        "Robot RobotDescription Gripper GripperDescription GripperError Tolerance ToolLimits "
        "JointLimits Payload RobotModel RobotError panda read_description verify"
    ),
    "bt_manip.kinematics": (
        "InverseKinematics IKProblem IKResult PoseTarget PositionTarget RotationTarget "
        "manipulability"
    ),
    "bt_manip.planning": (
        "Planner PlanningProblem PlanningResult RRTConnect LineTo ArcTo TurnAbout"
    ),
    "bt_manip.agents": (
        "Episodes Observations ObservationSpec Images ActionKind ActionSpace "
        "JointTorques JointTargets CartesianDeltas SubtreeChoice action_kind goal_progress "
        "LossCheck"
    ),
    "bt_manip.envs": "LearningTask Outcome DmEnvironment",
    "bt_manip.evaluation": (
        "Evaluation EpisodeId EpisodeResult EpisodeWorker evaluate run_episodes Worker "
        "WorkerDiedError RayPool ResultFolder read_results SuccessRate wilson_interval "
        "PairedTable mcnemar_p_value newcombe_interval "
        "Parameter parse_parameter grid samples"
    ),
    "bt_manip.demonstrations": (
        "Demonstration DemonstrationStore DemonstrationRecorder read_demonstrations "
        "write_robomimic write_demonstration_table write_lerobot"
    ),
    "bt_manip.arm": "Arm",
    "bt_manip.control": (
        "Controller ControlError ComputedTorque GravityCompensatedPD NativePD Reference Hold"
    ),
    "bt_manip.models": "ModelError load_model find_model bundled_path",
    "bt_manip.plugins": "load_plugins Plugins",
    "bt_manip.runner": (
        "Station TreeResult RunObserver RunRequest Run prepare request_of find_tree "
        "save_snapshot load_snapshot"
    ),
    "bt_manip.scenes": "Scene SceneRobot Fixture table_and_basket two_arms",
    "bt_manip.testing": (
        "Trial Stub Example contracts_of trees_of run_tree Situations built_in_situations play "
        "AT_REST assert_stands_still assert_touches_only assert_tower"
    ),
}
"""Names that keep their meaning until the next major version."""

EXPERIMENTAL = {
    "bt_manip.spatial": "quat_wxyz",
    "bt_manip.models": (
        "FoundModel MjcfModel ModelFormat ModelCache Progress terminal_progress check_downloads "
        "model_name find_package_file read_xml read_png image_of_obj Mesh read_mesh Assets SOLREF"
    ),
    "bt_manip.bt": "read_tree Reading declare Stubs Libraries LeafMapping",
    "bt_manip.exceptions": "one_line shown",
    "bt_manip.input_files": "read_bytes",
    "bt_manip.cell": (
        "entity_of extent bottom_of why_not_on ContactEvent ParametricEntity unique_name"
    ),
    "bt_manip.cell.randomization": "Randomization",
    "bt_manip.collision": "CollisionWorld FreeSpace CollisionPair",
    "bt_manip.trajectories": (
        "Trajectory PathTrajectory SplinePath StraightPath time_parameterize plan_stop limit_use"
    ),
    "bt_manip.planning": "edge_is_free shortcut",
    "bt_manip.grippers": (
        "TwoFingerGripper NativeTwoFingerGripper two_finger_gripper find_fingers FoundFingers "
        "FingerTravel SuctionGripper suction_gripper GRIP_DEPTH Solid"
    ),
    "bt_manip.grasping": ("GraspPlanner GripperClearance with_clearance SUFFICIENT_CLEARANCE"),
    "bt_manip.robots": "GraspGenerator GraspCandidates FoundGripper effort_limit ensure_motors",
    "bt_manip.evaluation": "StressTester StressEpisode plan_episodes",
    "bt_manip.robot_setup": "describe_robot try_robot",
    "bt_manip.toml_fields": "Key documented read_part",
    "bt_manip.toml_tables": "TomlTable",
    "bt_manip.control": "ControllerManager",
    "bt_manip.record": (
        "Recorder RunReport Trace read_report read_trace McapRecorder Recording RecordingError "
        "RecordedRun RecordedScene VideoRecorder write_csv write_parquet write_mcap write_video "
        "Continuation RecordedInterventions restore_snapshot"
    ),
    "bt_manip.behaviours": "ObjectCondition default_force",
    "bt_manip.agents": "differential_ik command_gripper displaced end_velocity held_payload",
    "bt_manip.scenes": "scene_of",
    "bt_manip.runner": (
        "EventQueue RunEvent KINDS TreeSource Interventions RunLoop Actor RunModifier make_station"
    ),
    "bt_manip.faults": "Fault FaultContext FaultError FaultInjector parameter parse_fault",
    "bt_manip.viewer": "render write_png NoOpenGLError Page Panel",
}
"""Names that may still change in a minor version; the changelog says so."""

HEAD = """# Public API

What is on this page may be imported by users and plugins. *Stable* names keep their meaning until
the next major version; *experimental* ones may change in a minor version, and the changelog says
so. Everything else in `bt_manip` is internal, even where Python lets you import it. The hooks of
plugins are on [a page of their own](../hooks.md).

The page of each package has arguments, shapes, units, frames and errors, as `help(name)` does.
"""


def names() -> dict[str, dict[str, str]]:
    """Give the documented names of each package, with their stability."""
    found: dict[str, dict[str, str]] = {}
    for stability, packages in (("stable", STABLE), ("experimental", EXPERIMENTAL)):
        for package, text in packages.items():
            found.setdefault(package, {}).update(dict.fromkeys(text.split(), stability))
    return found


def page() -> str:
    """Give the text of the page.

    Raises:
        AttributeError: When a documented name does not exist.
    """
    parts = [HEAD]
    for package, known in names().items():
        module = importlib.import_module(package)
        parts.append(f"\n## `{package}`\n\n| name | | |\n|---|---|---|\n")
        for name, stability in known.items():
            parts.append(f"| `{name}` | {stability} | {first_line(getattr(module, name))} |\n")
    return "".join(parts)


def first_line(thing: object) -> str:
    """Give the first line of a docstring; nothing for plain values, whose class has one."""
    if not (inspect.isclass(thing) or callable(thing)):
        return ""
    text = (inspect.getdoc(thing) or "").partition("\n\n")[0].replace("\n", " ")
    return text.replace("|", "\\|")


if __name__ == "__main__":
    print(page())
