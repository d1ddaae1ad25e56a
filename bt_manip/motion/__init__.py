"""Motion: inverse kinematics, trajectories and the arm that follows them."""

from .arm import Arm as Arm
from .collision import CollisionWorld as CollisionWorld
from .collision import FreeSpace as FreeSpace
from .collision import Near as Near
from .deviation_guard import DeviationGuard as DeviationGuard
from .effort import within_effort as within_effort
from .errors import MotionError as MotionError
from .kinematics import IKResult as IKResult
from .kinematics import InverseKinematics as InverseKinematics
from .limit_check import LimitUse as LimitUse
from .limit_check import effort_use as effort_use
from .limit_check import limit_use as limit_use
from .paths import SplinePath as SplinePath
from .paths import StraightPath as StraightPath
from .planning import Planner as Planner
from .planning import Planning as Planning
from .planning import PlanningProblem as PlanningProblem
from .planning import RRTConnect as RRTConnect
from .traffic import Traffic as Traffic
from .trajectory import JointTrajectory as JointTrajectory
from .trajectory import PathTrajectory as PathTrajectory
from .trajectory import SequenceTrajectory as SequenceTrajectory
from .trajectory import Trajectory as Trajectory
from .trajectory import trajectory_from_state as trajectory_from_state
