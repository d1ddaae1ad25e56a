"""Episodes of trees for agents: reset, observations, actions, success."""

from .actions import ActionKind as ActionKind
from .actions import ActionSpace as ActionSpace
from .actions import action_kind as action_kind
from .arm_actions import ArmAction as ArmAction
from .arm_actions import CartesianDeltas as CartesianDeltas
from .arm_actions import JointTargets as JointTargets
from .arm_actions import JointTorques as JointTorques
from .arm_actions import command_gripper as command_gripper
from .arm_actions import displaced as displaced
from .arm_actions import held_payload as held_payload
from .differential_ik import differential_ik as differential_ik
from .episodes import STEP as STEP
from .episodes import Episodes as Episodes
from .observations import ROBOT as ROBOT
from .observations import Images as Images
from .observations import Observations as Observations
from .observations import ObservationSpec as ObservationSpec
from .progress import LossCheck as LossCheck
from .progress import goal_progress as goal_progress
from .progress import without_progress as without_progress
from .references import end_velocity as end_velocity
from .subtree_choice import SubtreeChoice as SubtreeChoice
