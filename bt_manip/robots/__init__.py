"""Robots: description, composer entity and the Pinocchio model that agrees with MuJoCo."""

from .addresses import reader as reader
from .addresses import writer as writer
from .description_file import read_description as read_description
from .errors import GripperError as GripperError
from .errors import RobotError as RobotError
from .grasp_candidates import GraspCandidate as GraspCandidate
from .grasp_candidates import GraspCandidates as GraspCandidates
from .gripper import GraspGenerator as GraspGenerator
from .gripper import Gripper as Gripper
from .gripper import GripperDescription as GripperDescription
from .joint_limits import JointLimits as JointLimits
from .joint_limits import effort_limit as effort_limit
from .model_building import build_model as build_model
from .motors import ensure_motors as ensure_motors
from .panda import panda as panda
from .payload import Payload as Payload
from .robot import Robot as Robot
from .robot import WristWrench as WristWrench
from .robot import compile_alone as compile_alone
from .robot_description import RobotDescription as RobotDescription
from .robot_description import ToolLimits as ToolLimits
from .robot_model import RobotModel as RobotModel
from .verification import Verification as Verification
from .verification import verify as verify
