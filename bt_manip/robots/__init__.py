"""Robots: description, composer entity and a Pinocchio model equivalent to MuJoCo's."""

from bt_manip import lazy_exports

from .addresses import reader as reader
from .addresses import writer as writer
from .assembly import assemble as assemble
from .assembly import element_names as element_names
from .assembly import model_file as model_file
from .assembly import read_model as read_model
from .assembly import site_pose as site_pose
from .bounds import ArmBounds as ArmBounds
from .checks import check_configuration as check_configuration
from .checks import check_count as check_count
from .checks import check_generator as check_generator
from .checks import check_non_negative as check_non_negative
from .checks import check_number as check_number
from .checks import check_pose as check_pose
from .checks import check_positive as check_positive
from .checks import check_rotation as check_rotation
from .checks import check_speed as check_speed
from .checks import check_vector as check_vector
from .checks import invalid as invalid
from .configurations import Configuration as Configuration
from .configurations import Configurations as Configurations
from .configurations import load_configurations as load_configurations
from .connection import ArmConnection as ArmConnection
from .connection import GripperConnection as GripperConnection
from .connection import LateError as LateError
from .description_file import read_description as read_description
from .description_file import read_gripper as read_gripper
from .device import ArmDevice as ArmDevice
from .device import Backend as Backend
from .device import DeviceError as DeviceError
from .device import DeviceState as DeviceState
from .device import GripperDevice as GripperDevice
from .device import GripperState as GripperState
from .device_address import DeviceAddress as DeviceAddress
from .errors import GripperError as GripperError
from .errors import RobotError as RobotError
from .grasp_candidates import GraspCandidate as GraspCandidate
from .grasp_candidates import GraspCandidates as GraspCandidates
from .gripper import GRIP_FORCE as GRIP_FORCE
from .gripper import FoundGripper as FoundGripper
from .gripper import GraspGenerator as GraspGenerator
from .gripper import Gripper as Gripper
from .gripper_description import GripperDescription as GripperDescription
from .model_address import MENAGERIE as MENAGERIE
from .motion_limits import CONTROL_STEP as CONTROL_STEP
from .motion_limits import ROUNDING as ROUNDING
from .motion_limits import JointLimits as JointLimits
from .motion_limits import Limited as Limited
from .motion_limits import LimitUse as LimitUse
from .motion_limits import MotionLimits as MotionLimits
from .motion_limits import sampling_bounds as sampling_bounds
from .motors import effort_limit as effort_limit
from .motors import ensure_motors as ensure_motors
from .panda import panda as panda
from .payload import Payload as Payload
from .robot import Robot as Robot
from .robot import compile_alone as compile_alone
from .robot_description import RobotDescription as RobotDescription
from .robot_description import Tolerance as Tolerance
from .robot_description import ToolLimits as ToolLimits
from .robot_model import RobotModel as RobotModel

__getattr__ = lazy_exports(__name__)  # names the package of what has moved
