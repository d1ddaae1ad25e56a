"""Episodes of trees: reset, observations, actions of agents and of the expert, success."""

from .actions import ACTIONS as ACTIONS
from .actions import ActionKind as ActionKind
from .actions import ActionSpace as ActionSpace
from .actions import CartesianDeltas as CartesianDeltas
from .actions import JointTargets as JointTargets
from .actions import JointTorques as JointTorques
from .actions import SubtreeChoice as SubtreeChoice
from .actions import action_kind as action_kind
from .actions import differential_ik as differential_ik
from .episodes import STEP as STEP
from .episodes import Episodes as Episodes
from .observations import Images as Images
from .observations import Observations as Observations
from .observations import ObservationSpec as ObservationSpec
from .progress import LossCheck as LossCheck
from .progress import goal_progress as goal_progress
