"""Grasp planning: candidates, their ranking, gripper clearance and approaches."""

from .grasp_planner import GraspPlanner as GraspPlanner
from .grasp_search import CheckedGrasps as CheckedGrasps
from .grip_friction import check_friction as check_friction
from .grip_friction import holding_force as holding_force
from .gripper_clearance import SUFFICIENT_CLEARANCE as SUFFICIENT_CLEARANCE
from .gripper_clearance import GripperClearance as GripperClearance
from .gripper_clearance import with_clearance as with_clearance
from .reach_from_above import DROP_HEIGHTS as DROP_HEIGHTS
from .reach_from_above import REFERENCE_AREA as REFERENCE_AREA
from .reach_from_above import ReachFromAbove as ReachFromAbove
