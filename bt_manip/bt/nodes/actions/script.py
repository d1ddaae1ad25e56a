"""Script and ScriptCondition: a piece of the scripting language as a leaf."""

from bt_manip.bt.nodes.action import Condition, SyncAction
from bt_manip.bt.nodes.scripted import ScriptPort
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, SUCCESS, NodeStatus


class Script(ScriptPort, SyncAction):
    """Run a script.

    | tick | SUCCESS; an error in the script is an error of the tree |
    |------|---------------------------------------------------------|
    | halt | nothing                                                 |
    """

    code = Input(str, doc="the script")

    def _tick(self) -> NodeStatus:
        script = self._script()
        if script is not None:
            script.evaluate(self._environment())
        return SUCCESS


class ScriptCondition(ScriptPort, Condition):
    """Run a script, and succeed if its value is true.

    | tick | SUCCESS if the value is true, else FAILURE; an error is an error of the tree |
    |------|------------------------------------------------------------------------------|
    | halt | nothing                                                                      |
    """

    code = Input(doc="the script; its value decides")

    def _tick(self) -> NodeStatus:
        if self._is_true(self._script()):
            return SUCCESS
        self._because(f"not: {self._source}")
        return FAILURE
