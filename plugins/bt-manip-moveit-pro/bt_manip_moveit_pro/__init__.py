"""Trees of MoveIt Pro: its dialect, its nodes and its sub-trees."""

from bt_manip_moveit_pro.for_each import ForEach as ForEach
from bt_manip_moveit_pro.for_each import ForEachUntilSuccess as ForEachUntilSuccess
from bt_manip_moveit_pro.mapping import LeafMapping as LeafMapping
from bt_manip_moveit_pro.repeat_unless_failure import (
    RepeatUnlessFailureEachTick as RepeatUnlessFailureEachTick,
)
from bt_manip_moveit_pro.repeat_unless_failure import (
    RepeatUnlessFailureWithinTick as RepeatUnlessFailureWithinTick,
)
