"""Trajectories: time parameterization, time scaling, stops, and their limits."""

from bt_manip.robots import CONTROL_STEP as CONTROL_STEP

from .limit_check import EFFORT_FRACTION as EFFORT_FRACTION
from .limit_check import effort_use as effort_use
from .limit_check import limit_use as limit_use
from .limit_check import tool_use as tool_use
from .motion_profile import MotionProfile as MotionProfile
from .motion_profile import joint_profiles as joint_profiles
from .motion_profile import velocity_profiles as velocity_profiles
from .path_limits import PathLimits as PathLimits
from .paths import Path as Path
from .paths import SplinePath as SplinePath
from .paths import StraightPath as StraightPath
from .stopping import plan_stop as plan_stop
from .time_parameterization import scale_to_effort_limits as scale_to_effort_limits
from .time_parameterization import time_parameterize as time_parameterize
from .time_parameterization import time_parameterize_segment as time_parameterize_segment
from .time_scaling import at_speed_scale as at_speed_scale
from .time_scaling import change_speed_scale as change_speed_scale
from .topp import TOPP_GRIDS as TOPP_GRIDS
from .trajectory import BlendedTrajectory as BlendedTrajectory
from .trajectory import JointTrajectory as JointTrajectory
from .trajectory import PathTrajectory as PathTrajectory
from .trajectory import Samples as Samples
from .trajectory import SequenceTrajectory as SequenceTrajectory
from .trajectory import TailTrajectory as TailTrajectory
from .trajectory import TimeScaledTrajectory as TimeScaledTrajectory
from .trajectory import Trajectory as Trajectory
from .trajectory import sample_times as sample_times
from .trajectory import time_scaling_state as time_scaling_state
from .trajectory import trajectory_from_state as trajectory_from_state
