"""Script and ScriptCondition: a piece of the scripting language as a leaf."""

from typing import ClassVar

from bt_manip.bt.nodes.action import Condition, SyncAction
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.port_types import STRING
from bt_manip.bt.ports import Input
from bt_manip.bt.script.evaluation import Environment, is_true
from bt_manip.bt.script.parser import ParsedScript, parse_script
from bt_manip.bt.status import FAILURE, SUCCESS, NodeStatus
from bt_manip.bt.traits import SUCCEEDS
from bt_manip.exceptions import ScriptError


class ScriptPort(Node):
    """The part of a node that reads a script from a port, and parses it when its text changes."""

    checked_port = "code"
    double_quotes = False
    """Whether strings may stand between double quotes, as in MoveIt Pro."""
    _source = ""
    _parsed: ParsedScript | None = None

    def check_ports(self) -> None:
        """Raise a `PortError` if nothing was given, and a `ScriptError` if it is no script."""
        self._script()

    def _script(self) -> ParsedScript | None:
        return self.parsed(self.read_port(self.checked_port, STRING))

    def parsed(self, text: str) -> ParsedScript | None:
        """Return the script of a text of the port; raise a `ScriptError` if it is none."""
        if text != self._source:
            self._parsed = parse_script(text, double_quotes=self.double_quotes)
            self._source = text
        return self._parsed

    def _environment(self) -> Environment:
        return Environment(self.scope, self.runtime.enums)

    def _is_true(self, script: ParsedScript | None) -> bool:
        if script is None:
            raise ScriptError("the script is empty: it is neither true nor false")
        return is_true(script.evaluate(self._environment()))


class Script(ScriptPort, SyncAction):
    """Run a script.

    | tick | SUCCESS; an error in the script is an error of the tree |
    |------|---------------------------------------------------------|
    | halt | nothing                                                 |
    """

    traits: ClassVar = SUCCEEDS
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
