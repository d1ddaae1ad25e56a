"""Environments for learning: Gymnasium's and dm_env's, of any tree that declares its goal.

Importing this registers the environments with Gymnasium, where that is installed: a registered
tree that needs no settings is ``bt_manip/NAME-v0``, its name in CamelCase.
"""

from .dm_environment import DmEnvironment as DmEnvironment
from .learning_task import REWARDS as REWARDS
from .learning_task import LearningTask as LearningTask
from .learning_task import Outcome as Outcome
from .registration import environment_id as environment_id
