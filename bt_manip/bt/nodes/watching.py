"""Noticing that an entry of the blackboard was written."""

from bt_manip.bt.nodes.node import Node


class Watching(Node):
    """The part of a node that looks whether the entry of its port ``entry`` was written."""

    _seen = 0

    @property
    def checked_port(self) -> str:
        """The port whose entry is watched."""
        return "entry"

    def check_ports(self) -> None:
        """Check what must be right before the first tick.

        Raises:
            PortError: If the entry is not named.
        """
        if not self.given.get("entry"):
            raise self._port_error("entry", "nothing was given; expected {key}")

    def _was_updated(self) -> bool:
        """Tell whether the entry was written since the last call; a missing one was not."""
        text = str(self.given["entry"]).strip(" ")
        key = text[1:-1] if len(text) >= 3 and text[0] == "{" and text[-1] == "}" else text
        found = self.scope.entry(key)
        if found is None:
            return False
        seen = self._seen
        self._seen = found.sequence
        return seen != found.sequence
