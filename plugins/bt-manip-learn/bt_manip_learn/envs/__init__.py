"""Learning environments of Gymnasium and dm_env for any tree that declares its goal.

Importing this package registers environments with Gymnasium: each registered tree without required
settings is ``bt_manip/NAME-v0``, its name in CamelCase.
"""

from .dm_environment import DmEnvironment as DmEnvironment
from .learning_task import LearningTask as LearningTask
from .learning_task import Outcome as Outcome
from .registration import environment_id as environment_id
