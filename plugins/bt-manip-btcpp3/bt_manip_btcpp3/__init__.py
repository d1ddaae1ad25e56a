"""Trees of BehaviorTree.CPP 3: its dialect, and the nodes that differ from those of version 4."""

from bt_manip_btcpp3.dialect import BTCPP3 as BTCPP3
from bt_manip_btcpp3.nodes import BlackboardCheckBool as BlackboardCheckBool
from bt_manip_btcpp3.nodes import BlackboardCheckDouble as BlackboardCheckDouble
from bt_manip_btcpp3.nodes import BlackboardCheckInt as BlackboardCheckInt
from bt_manip_btcpp3.nodes import BlackboardCheckString as BlackboardCheckString
from bt_manip_btcpp3.nodes import Parallel as Parallel
from bt_manip_btcpp3.nodes import Repeat as Repeat
from bt_manip_btcpp3.nodes import RetryUntilSuccessful as RetryUntilSuccessful
from bt_manip_btcpp3.nodes import SequenceStar as SequenceStar
from bt_manip_btcpp3.nodes import SetBlackboard as SetBlackboard
from bt_manip_btcpp3.nodes import SubTree as SubTree
from bt_manip_btcpp3.nodes import Switch2 as Switch2
from bt_manip_btcpp3.nodes import Switch3 as Switch3
from bt_manip_btcpp3.nodes import Switch4 as Switch4
from bt_manip_btcpp3.nodes import Switch5 as Switch5
from bt_manip_btcpp3.nodes import Switch6 as Switch6
