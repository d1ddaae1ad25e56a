"""Faults for runs, and stress tests of trees: each fault at each phase, judged by the physics.

Names are imported on first use: the command line asks for the options of this package alone.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip_stress.faults.fault import Fault as Fault
    from bt_manip_stress.faults.fault import FaultContext as FaultContext
    from bt_manip_stress.faults.fault import FaultError as FaultError
    from bt_manip_stress.faults.fault import parameter as parameter
    from bt_manip_stress.faults.injector import FaultInjector as FaultInjector
    from bt_manip_stress.faults.planned_fault import PlannedFault as PlannedFault
    from bt_manip_stress.faults.planned_fault import parse_fault as parse_fault
    from bt_manip_stress.stress_table import LEGEND as LEGEND
    from bt_manip_stress.stress_table import StressTable as StressTable
    from bt_manip_stress.stress_test import StressEpisode as StressEpisode
    from bt_manip_stress.stress_test import StressPhase as StressPhase
    from bt_manip_stress.stress_test import StressResult as StressResult
    from bt_manip_stress.stress_test import StressTester as StressTester
    from bt_manip_stress.stress_test import lost_stress as lost_stress
    from bt_manip_stress.stress_test import plan_episodes as plan_episodes

__getattr__ = lazy_exports(__name__)
