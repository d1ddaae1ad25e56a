"""Collision-free paths in joint space, and Cartesian paths of the tool."""

from .back_off import plan_back_off as plan_back_off
from .blending import MAX_BLEND as MAX_BLEND
from .blending import blend as blend
from .blending import tool_distance as tool_distance
from .collision_check import check_goals as check_goals
from .collision_check import check_tool_path as check_tool_path
from .collision_check import collision_free_goals as collision_free_goals
from .collision_check import trajectory_is_free as trajectory_is_free
from .collision_free_motion import plan_collision_free_motion as plan_collision_free_motion
from .goal_selection import goal_configurations as goal_configurations
from .goal_selection import plan_straight_approach as plan_straight_approach
from .goal_selection import translate_along_tool_z as translate_along_tool_z
from .joint_segments import discretize_segment as discretize_segment
from .joint_segments import edge_is_free as edge_is_free
from .path_simplification import shortcut as shortcut
from .planner import Planner as Planner
from .planner import PlanningProblem as PlanningProblem
from .planner import PlanningResult as PlanningResult
from .rrt_connect import RRTConnect as RRTConnect
from .tool_path import ArcTo as ArcTo
from .tool_path import LineTo as LineTo
from .tool_path import Step as Step
from .tool_path import TurnAbout as TurnAbout
from .tool_path import tool_paths as tool_paths
from .tool_path_following import follow_tool_path as follow_tool_path
