"""Inverse kinematics."""

from .inverse_kinematics import DISTINCT as DISTINCT
from .inverse_kinematics import InverseKinematics as InverseKinematics
from .manipulability import manipulability as manipulability
from .null_space_motion import null_space_step as null_space_step
from .problem import IKProblem as IKProblem
from .problem import IKResult as IKResult
from .targets import PoseTarget as PoseTarget
from .targets import PositionTarget as PositionTarget
from .targets import RotationTarget as RotationTarget
from .targets import Target as Target
