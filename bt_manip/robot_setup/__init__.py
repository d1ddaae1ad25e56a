"""Robot setup: describe a robot from its model, check a description, show it."""

from .check import check_description as check_description
from .describe import describe_robot as describe_robot
from .inspection import make_robot as make_robot
from .inspection import picture as picture
from .inspection import summary as summary
from .known_grippers import gripper_names as gripper_names
from .tasks import why_not as why_not
from .trial import try_robot as try_robot
