"""How an object can be gripped, and which way of that the arm takes."""

from .antipodal import antipodal_pairs as antipodal_pairs
from .candidates import Candidates as Candidates
from .choice import GraspChoice as GraspChoice
from .grasp import Grasp as Grasp
from .gripper_clearance import GripperClearance as GripperClearance
from .gripper_clearance import Room as Room
from .gripper_clearance import with_clearance as with_clearance
from .hand import Hand as Hand
from .hand import measure_hand as measure_hand
from .solid import Solid as Solid
from .solid import solids_of as solids_of
from .way_in import Chosen as Chosen
