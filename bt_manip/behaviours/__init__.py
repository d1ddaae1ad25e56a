"""Leaves of trees: hover, reach, grasp, lift, drop and their kin."""

from .approach import Approach as Approach
from .approach import Retreat as Retreat
from .close_gripper import CloseGripper as CloseGripper
from .drop import Drop as Drop
from .follow_target import FollowTarget as FollowTarget
from .grasp import Grasp as Grasp
from .hover import Hover as Hover
from .is_at import IsAt as IsAt
from .is_holding import IsHolding as IsHolding
from .lift import Lift as Lift
from .move_arc import MoveArc as MoveArc
from .move_home import MoveHome as MoveHome
from .move_linear import MoveLinear as MoveLinear
from .move_through import MoveThrough as MoveThrough
from .move_to_configuration import MoveToConfiguration as MoveToConfiguration
from .move_to_pose import MoveToPose as MoveToPose
from .object_exists import ObjectExists as ObjectExists
from .open_gripper import OpenGripper as OpenGripper
from .place import PlaceAt as PlaceAt
from .place import PlaceOn as PlaceOn
from .reach import Reach as Reach
from .remove_object import RemoveObject as RemoveObject
from .set_speed import SetSpeed as SetSpeed
from .spawn_object import SpawnObject as SpawnObject
from .stop import Stop as Stop
from .switch_controller import SwitchController as SwitchController
