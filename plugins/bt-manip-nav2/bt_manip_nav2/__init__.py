"""Nav2's control nodes and decorators."""

from bt_manip_nav2.controls import NonblockingSequence as NonblockingSequence
from bt_manip_nav2.controls import PersistentSequence as PersistentSequence
from bt_manip_nav2.controls import PipelineSequence as PipelineSequence
from bt_manip_nav2.controls import RecoveryNode as RecoveryNode
from bt_manip_nav2.controls import RoundRobin as RoundRobin
from bt_manip_nav2.decorators import DistanceController as DistanceController
from bt_manip_nav2.decorators import GoalUpdatedController as GoalUpdatedController
from bt_manip_nav2.decorators import GoalUpdater as GoalUpdater
from bt_manip_nav2.decorators import PathLongerOnApproach as PathLongerOnApproach
from bt_manip_nav2.decorators import RateController as RateController
from bt_manip_nav2.decorators import SingleTrigger as SingleTrigger
from bt_manip_nav2.decorators import SpeedController as SpeedController
