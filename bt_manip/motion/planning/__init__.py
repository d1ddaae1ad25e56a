"""Paths in joint space around what is in the way."""

from .planner import Planner as Planner
from .planner import Planning as Planning
from .planner import PlanningProblem as PlanningProblem
from .rrt_connect import RRTConnect as RRTConnect
from .shortening import shortened as shortened
from .smoothing import smooth_paths as smooth_paths
