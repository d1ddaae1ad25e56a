"""The part of a node whose behaviour is a script in one of its ports."""

from typing import ClassVar

from bt_manip.bt.nodes.node import Node
from bt_manip.bt.port_types import STRING
from bt_manip.bt.script.evaluation import Environment, is_true
from bt_manip.bt.script.parser import ParsedScript, parse_script
from bt_manip.exceptions import ScriptError


class ScriptPort(Node):
    """Reads a script from a port; it is parsed again only when its text changes."""

    script_port: ClassVar[str] = "code"
    """Its name."""
    double_quotes = False
    """Whether strings may stand between double quotes, as in MoveIt Pro."""
    _source = ""
    _parsed: ParsedScript | None = None

    @property
    def checked_port(self) -> str:
        """The port that holds the script."""
        return self.script_port

    def check_ports(self) -> None:
        """Check what must be right before the first tick.

        Raises:
            PortError: If nothing was given.
            ScriptError: If it is no script.
        """
        self._script()

    def _script(self) -> ParsedScript | None:
        text = self.read_port(self.script_port, STRING)
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
