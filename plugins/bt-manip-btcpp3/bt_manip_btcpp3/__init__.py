"""Trees of BehaviorTree.CPP 3: its dialect, and the nodes that differ from those of version 4."""

from bt_manip_btcpp3.dialect import BTCPP3 as BTCPP3
