"""The built-in leaves."""

from bt_manip.bt.nodes.actions.blackboard import SetBlackboard as SetBlackboard
from bt_manip.bt.nodes.actions.blackboard import UnsetBlackboard as UnsetBlackboard
from bt_manip.bt.nodes.actions.blackboard import WasEntryUpdated as WasEntryUpdated
from bt_manip.bt.nodes.actions.constant import AlwaysFailure as AlwaysFailure
from bt_manip.bt.nodes.actions.constant import AlwaysSuccess as AlwaysSuccess
from bt_manip.bt.nodes.actions.script import Script as Script
from bt_manip.bt.nodes.actions.script import ScriptCondition as ScriptCondition
from bt_manip.bt.nodes.actions.sleep import Sleep as Sleep
