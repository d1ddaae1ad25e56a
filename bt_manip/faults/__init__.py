"""Fault injection: disturbances of the cell, the robot and the tree.

Each name is imported on first use: every run registers the faults, few inject them.
"""

from typing import TYPE_CHECKING

from bt_manip.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from bt_manip.faults.fault import Fault as Fault
    from bt_manip.faults.fault import FaultContext as FaultContext
    from bt_manip.faults.fault import FaultError as FaultError
    from bt_manip.faults.fault import parameter as parameter
    from bt_manip.faults.injector import FaultInjector as FaultInjector
    from bt_manip.faults.object_faults import ContainerVanishes as ContainerVanishes
    from bt_manip.faults.object_faults import Displace as Displace
    from bt_manip.faults.object_faults import Heavy as Heavy
    from bt_manip.faults.object_faults import Knock as Knock
    from bt_manip.faults.object_faults import Obstacle as Obstacle
    from bt_manip.faults.object_faults import Slippery as Slippery
    from bt_manip.faults.object_faults import Stuck as Stuck
    from bt_manip.faults.object_faults import Vanish as Vanish
    from bt_manip.faults.planned_fault import PlannedFault as PlannedFault
    from bt_manip.faults.planned_fault import parse_fault as parse_fault
    from bt_manip.faults.robot_faults import Push as Push
    from bt_manip.faults.robot_faults import SensorDelay as SensorDelay
    from bt_manip.faults.robot_faults import SensorNaN as SensorNaN
    from bt_manip.faults.robot_faults import SensorNoise as SensorNoise
    from bt_manip.faults.robot_faults import StuckFinger as StuckFinger
    from bt_manip.faults.robot_faults import StuckJoint as StuckJoint
    from bt_manip.faults.robot_faults import TorqueLoss as TorqueLoss
    from bt_manip.faults.tree_faults import BehaviourException as BehaviourException
    from bt_manip.faults.tree_faults import TickDelay as TickDelay

__getattr__ = lazy_exports(
    __name__,
    {
        "bt_manip.faults.fault": "Fault FaultContext FaultError parameter",
        "bt_manip.faults.injector": "FaultInjector",
        "bt_manip.faults.object_faults": (
            "ContainerVanishes Displace Heavy Knock Obstacle Slippery Stuck Vanish"
        ),
        "bt_manip.faults.planned_fault": "PlannedFault parse_fault",
        "bt_manip.faults.robot_faults": (
            "Push SensorDelay SensorNaN SensorNoise StuckFinger StuckJoint TorqueLoss"
        ),
        "bt_manip.faults.tree_faults": "BehaviourException TickDelay",
    },
)
