"""Paths in joint space around what is in the way."""

from .collision_check import check_path as check_path
from .collision_check import check_targets as check_targets
from .collision_check import free_targets as free_targets
from .collision_check import trajectory_is_free as trajectory_is_free
from .collision_free_motion import plan_collision_free_motion as plan_collision_free_motion
from .goal_selection import ahead as ahead
from .goal_selection import goal_configurations as goal_configurations
from .goal_selection import straight_approach as straight_approach
from .planner import Planner as Planner
from .planner import PlanningProblem as PlanningProblem
from .planner import PlanningResult as PlanningResult
from .rrt_connect import RRTConnect as RRTConnect
from .shortcutting import shortcut as shortcut
from .smoothing import smooth_paths as smooth_paths
from .tool_path import ToolPath as ToolPath
from .tool_path import tool_paths as tool_paths
from .tool_path_following import SMOOTH as SMOOTH
from .tool_path_following import follow_path as follow_path
from .tool_path_steps import ArcTo as ArcTo
from .tool_path_steps import LineTo as LineTo
from .tool_path_steps import Step as Step
from .tool_path_steps import TurnAbout as TurnAbout
