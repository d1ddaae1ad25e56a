"""Leaves of MoveIt Pro that succeed without effect here, and their ports."""

from bt_manip_moveit_pro.leaf import Leaf

PORTS = {
    # what is only shown
    "VisualizePose": "pose marker_name marker_size marker_lifetime marker_text",
    "VisualizePath": "path marker_name marker_lifetime pose_marker_size show_poses",
    "VisualizeMesh": "mesh_path mesh_pose mesh_name marker_lifetime",
    "PublishMarkers": "marker_type marker_namespace marker_scale_xyz marker_poses",
    "SwitchUIPrimaryView": "primary_view_name",
    # questions to users: plans are approved, and the page and Groot2 have breakpoints of their own
    "WaitForUserPathApproval": "path",
    "WaitForMTCSolutionApproval": "cartesian_path_links solution",
    "BreakpointSubscriber": "breakpoint_topic message",
    # motions are planned in the cell as it is, from where the arm is; a cycle begins with the scene
    "ClearSnapshot": "",
    "ResetMujocoKeyframe": "keyframe_name response_timeout wait_for_server_available_timeout",
    "SetupMTCCurrentState": "task",
    "SetupMTCSetCollisionRule": "task name_a name_b allow_collision",
    # topics, services and controllers of ROS
    "PublishEmpty": "topic queue_size use_best_effort",
    "CallTriggerService": "service_name response_timeout wait_for_server_available_timeout",
    "SwitchController": (
        "activate_controllers deactivate_controllers activate_asap automatic_activation "
        "automatic_deactivation controller_list_action_name controller_switch_action_name "
        "strictness timeout"
    ),
}

# Attributes of the module, from which converted trees import them.
for _name, _ports in PORTS.items():
    _members = {"ignored": _ports, "__doc__": "Succeed, without effect.", "__module__": __name__}
    globals()[_name] = type(_name, (Leaf,), _members)
