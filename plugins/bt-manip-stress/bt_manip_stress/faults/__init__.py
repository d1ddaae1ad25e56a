"""Fault injection: disturbances of the cell, the robot and the tree."""

from .fault import Fault as Fault
from .fault import FaultContext as FaultContext
from .fault import FaultError as FaultError
from .fault import parameter as parameter
from .injector import FaultInjector as FaultInjector
from .object_faults import ContainerVanishes as ContainerVanishes
from .object_faults import Displace as Displace
from .object_faults import Heavy as Heavy
from .object_faults import Knock as Knock
from .object_faults import Obstacle as Obstacle
from .object_faults import Slippery as Slippery
from .object_faults import Stuck as Stuck
from .object_faults import Vanish as Vanish
from .planned_fault import PlannedFault as PlannedFault
from .planned_fault import parse_fault as parse_fault
from .robot_faults import Push as Push
from .robot_faults import SensorDelay as SensorDelay
from .robot_faults import SensorNaN as SensorNaN
from .robot_faults import SensorNoise as SensorNoise
from .robot_faults import StuckFinger as StuckFinger
from .robot_faults import StuckJoint as StuckJoint
from .robot_faults import TorqueLoss as TorqueLoss
from .tree_faults import BehaviourException as BehaviourException
from .tree_faults import TickDelay as TickDelay
