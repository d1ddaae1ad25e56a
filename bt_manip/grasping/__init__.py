"""Grasp planning: candidates, their ranking, gripper clearance and approaches."""

from .antipodal_grasps import GRIP_DEPTH as GRIP_DEPTH
from .antipodal_grasps import AntipodalGraspGenerator as AntipodalGraspGenerator
from .antipodal_sampling import antipodal_pairs as antipodal_pairs
from .grasp_candidates import GraspCandidate as GraspCandidate
from .grasp_planner import GraspPlanner as GraspPlanner
from .grasp_search import GraspPlan as GraspPlan
from .gripper_clearance import SUFFICIENT_CLEARANCE as SUFFICIENT_CLEARANCE
from .gripper_clearance import Clearance as Clearance
from .gripper_clearance import GripperClearance as GripperClearance
from .gripper_clearance import with_clearance as with_clearance
from .solids import Solid as Solid
from .solids import solids_of as solids_of
