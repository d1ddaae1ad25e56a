"""Public API: the names that users and plugin authors may import, and which of them are stable.

``python tools/api_page.py`` prints them with the first lines of their docstrings, as on the site.
"""

import importlib
import inspect
from functools import cache

STABLE = {
    "bt_manip": "build_station hookimpl",
    "bt_manip.exceptions": "BtManipError TreeError MotionError",
    "bt_manip.spatial": "pose pointing_down",
    "bt_manip.bt": (
        "Tree load_tree parse_tree tree_to_xml BehaviourRegistry Status NodeStatus Action "
        "Condition Control SubTree Input Output Sequence Fallback ReactiveFallback Parallel "
        "IfThenElse TryCatch Inverter ForceSuccess Repeat RetryUntilSuccessful Script Sleep "
        "KeepRunningUntilFailure "
        "SyncAction Decorator LoopString Dialect Traits"
    ),
    "bt_manip.behaviours": (
        "CellBehaviour MotionBehaviour SpawnObject RemoveObject ObjectExists IsIn Hover Reach "
        "Grasp Lift Drop PlaceOn PlaceAt IsHolding OpenGripper CloseGripper MoveToPose "
        "MoveToConfiguration MoveHome MoveLinear MoveThrough MoveArc Approach Retreat BackOff "
        "SetSpeed SwitchController WaitUntilAtRest WaitUntilUndisturbed ArmBehaviour "
        "RobotCondition ObjectCondition IsOn CellCondition ObjectInput"
    ),
    "bt_manip.cell": "Cell ParametricEntity is_in",
    "bt_manip.parameters": "Parameter",
    "bt_manip.cell.objects": "Cube",
    "bt_manip.robots": (
        "Robot RobotDescription Gripper JointLimits panda read_description GraspCandidates Backend "
        "ArmDevice GripperDevice DeviceState GripperState DeviceAddress DeviceError"
    ),
    "bt_manip.planning": "PlanningProblem PlanningResult RRTConnect",
    "bt_manip_learn.agents": "ActionKind ActionSpace",
    "bt_manip_learn.envs": "LearningTask",
    "bt_manip.control": "Controller",
    "bt_manip.models": "ModelError MjcfModel ModelFormat ModelCache",
    "bt_manip.plugins": "load_plugins",
    "bt_manip.runner": "Station RunObserver RunModifier RunView prepare request_of",
    "bt_manip.scenes": "Scene SceneRobot SceneObject PoseSource",
    "bt_manip.testing": ("Stub trees_of run_tree play assert_tower Check"),
    "bt_manip.evaluation": "ProcessPool",
    "bt_manip.grippers": "TwoFingerGripper two_finger_gripper",
    "bt_manip_contracts": "Example contracts_of DEVICE_CONTRACT GRIPPER_CONTRACT",
    "bt_manip_stress": "Fault parameter",
    "bt_manip_view": "Panel",
    "bt_manip_setup": "find_fingers",
}
"""Names that keep their meaning until the next major version."""

EXPERIMENTAL = {
    "bt_manip": "__version__ hookspec load_plugins load_tree lazy_exports",
    "bt_manip.exceptions": (
        "PortError BoundsError BlackboardError ScriptError UnknownBehaviourError NodeError "
        "did_you_mean one_line shown ANY_BUT_INTERRUPT reason_of "
        "with_short_values without_numbers"
    ),
    "bt_manip.spatial": "quat_wxyz",
    "bt_manip.bt": (
        "SequenceWithMemory AsyncSequence ReactiveSequence AsyncFallback ParallelAll "
        "WhileDoElse Switch2 Switch3 Switch4 Switch5 Switch6 ForceFailure "
        "RunOnce Delay Timeout Precondition SkipUnlessUpdated "
        "WaitValueUpdate LoopBool LoopDouble LoopInt AlwaysSuccess AlwaysFailure "
        "ScriptCondition SetBlackboard UnsetBlackboard WasEntryUpdated Blackboard InOut Comment "
        "as_written read_tree Reading ReadingOptions declare Stubs Libraries "
        "Document Element Problems PortType STRING DOUBLE is_pointer "
        "Node NodeKind texts_of instance_to_xml tree_instances editor_attributes "
        "node_name parse_goal port_attributes write_element CONDITIONS"
    ),
    "bt_manip.behaviours": (
        "IsAt FollowTarget Stop PlannedMove Recover pose_to_text pose_from_text pose_input "
        "pose_output poses_input poses_output centre_pose bottom_pose top_grasp_poses "
        "downward_poses nearest_orientation yaw_of payload_of extent feasible_force "
        "number_or_auto numbers_or_auto Destination"
    ),
    "bt_manip.cell": (
        "CellError OverlapError PhysicsDiverged Region Camera looking_at at_rest is_on "
        "entity_of extent bottom_of why_not_on why_not_in why_not_at_rest why_not_released "
        "is_within is_rest_velocity surrounds as_object ContactEvent unique_name FrameRenderer "
        "camera_number parse_size png "
        "write_png NoOpenGLError literal_name escaped_name Arena NO_CONTACTS OVERVIEW WORLD "
        "MonitoredEntity"
    ),
    "bt_manip.cell.objects": (
        "Prop PrimitiveProp Shape length ModelObject DeclaredGrasp Box Cylinder Sphere Capsule "
        "ConvexMesh Block Bottle Can Mug Basket Bin Tray Table Shelf Wall RedBlock GreenBlock "
        "BlueBlock YellowBlock geom_box"
    ),
    "bt_manip.robots": (
        "GripperError RobotError GripperDescription MotionLimits Tolerance ToolLimits "
        "Payload RobotModel sampling_bounds GraspGenerator FoundGripper effort_limit ensure_motors "
        "MENAGERIE assemble compile_alone element_names "
        "load_configurations model_file read_gripper read_model site_pose GraspCandidate "
        "LateError"
    ),
    "bt_manip.planning": "Planner LineTo ArcTo TurnAbout edge_is_free shortcut",
    "bt_manip_learn.agents": (
        "Episodes Observations ObservationSpec Images JointTorques JointTargets CartesianDeltas "
        "SubtreeChoice action_kind goal_progress LossCheck differential_ik command_gripper "
        "displaced end_velocity held_payload ArmAction STEP"
    ),
    "bt_manip.control": (
        "ControlError ComputedTorque GravityCompensatedPD Reference Hold "
        "ControllerManager MeasuredArm default_gains gain_array"
    ),
    "bt_manip.models": (
        "load_model find_model bundled_path FoundModel Progress terminal_progress "
        "check_downloads model_name find_package_file read_xml read_png image_of_obj Mesh "
        "read_mesh Assets SOLREF"
    ),
    "bt_manip.plugins": "Plugins guarded",
    "bt_manip.runner": (
        "TreeResult RunRequest Run find_tree known_behaviours save_snapshot load_snapshot "
        "EventQueue RunEvent "
        "KINDS TreeSource Interventions CommandedRobot RunLoop "
        "load_source next_digest recorder_for EventStream Pacing MAX_FORCE TICK "
        "PendingSteps STEP_FIELDS StepBlock StepLog html_table "
        "Believed FilledCell Hardware RobotBuilder make_robot"
    ),
    "bt_manip.scenes": "table_and_basket two_arms scene_of find_robot Level ExpectedObjects",
    "bt_manip.testing": (
        "Trial Situations built_in_situations AT_REST assert_stands_still assert_touches_only"
    ),
    "bt_manip.grippers": (
        "FingerTravel TwoFingerParameters travel_digests Polyhedron "
        "GRIP_DEPTH Solid solids_of BodySurface collision_geoms_of"
    ),
    "bt_manip_contracts": "ROBOT_CONTRACT RobotCase holds_an_object recovers_from_a_problem verify",
    "bt_manip_stress": (
        "FaultError FaultContext FaultInjector parse_fault StressTester StressEpisode plan_episodes"
    ),
    "bt_manip.parameters": "parameters_of read_words",
    "bt_manip.viewer": (
        "render write_png NoOpenGLError use_offscreen_opengl print_wrapped FREE_CAMERA"
    ),
    "bt_manip.evaluation": (
        "WorkerDiedError Evaluation EpisodeId EpisodeResult EpisodeWorker evaluate run_episodes "
        "Worker portable read_results SuccessRate wilson_interval mcnemar_p_value "
        "newcombe_interval call_in_process parse_point why_not"
    ),
    "bt_manip.record": (
        "RecordingError Recorder AppendedFile RunReport read_report "
        "restore_snapshot take_snapshot SnapshotAt FileInUseError check_writable "
        "cpu_name identify identity_differences open_output reading versions whole_file writing "
        "check_exists is_special CycleFigures Interval ExecutionLog LoggedNode RobotFigures "
        "RobotState RunFigures StepFigures live_state"
    ),
    "bt_manip.registry": "Registry Parts",
    "bt_manip.kinematics": (
        "InverseKinematics IKProblem IKResult PoseTarget PositionTarget RotationTarget "
        "manipulability"
    ),
    "bt_manip_learn.envs": "Outcome DmEnvironment",
    "bt_manip_learn.demonstrations": (
        "Demonstration DemonstrationStore DemonstrationRecorder read_demonstrations "
        "write_robomimic write_demonstration_table write_lerobot write_minari"
    ),
    "bt_manip.arm": "Arm",
    "bt_manip.files": "read_bytes read_text replace_text",
    "bt_manip.cell.randomization": "Randomization",
    "bt_manip.collision": (
        "CollisionWorld hull_points moved_bodies permanent_self_collisions self_collisions"
    ),
    "bt_manip.trajectories": (
        "Trajectory PathTrajectory SplinePath StraightPath time_parameterize plan_stop"
    ),
    "bt_manip.grasping": (
        "GraspPlanner GripperClearance with_clearance SUFFICIENT_CLEARANCE holding_force "
        "CheckedGrasps"
    ),
    "bt_manip_recording": (
        "McapRecorder Recording RecordedRun RecordedScene Continuation RecordedInterventions "
        "Timeline Trace jpeg log_line read_trace record_states running_leaves write_csv write_mcap "
        "write_npz write_parquet write_trace CellScene SceneSource SceneCamera VisualShape "
        "TexturedMesh Triangles PLANE_THICKNESS timestamp_of tool_path"
    ),
    "bt_manip_convert": "to_python",
    "bt_manip_hands": "Hand SuctionGripper suction_gripper",
    "bt_manip_setup": "describe_robot description_text check_description try_robot",
    "bt_manip_setup.finger_travel": "FoundFingers measured write_travel",
    "bt_manip.toml": "Key TomlTable documented parse_toml read_part toml_text write_fields",
    "bt_manip.cli": (
        "BAD_INPUT FAILED GroupedCommand INTERRUPTED SUCCESS Interrupt PluginGroup RunOptions "
        "Session StationOptions ViewingCommand chosen complete_part execute_run exit_code_help "
        "findings_of given_options json_option load_chosen_plugins print_cycles print_json "
        "print_warning run_app run_tracked takes vary_option workers_option"
    ),
    "bt_manip_view": (
        "Page ReplayPage VideoRecorder results_page run_page save_configuration write_video"
    ),
}
"""Names that may still change in a minor version; the changelog says so."""

HEAD = """# Public API

What is on this page may be imported by users and plugins. *Stable* names keep their meaning until
the next major version; *experimental* ones may change in a minor version, and the changelog says
so. Everything else in `bt_manip` is internal, even where Python lets you import it. Nodes keep
their names and ports in XML trees also where their classes are experimental. The hooks of plugins
are on [a page of their own](../hooks.md).

The page of each package has arguments, shapes, units, frames and errors, as `help(name)` does.
"""


@cache
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
