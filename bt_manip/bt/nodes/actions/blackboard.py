"""Leaves that work on entries of the blackboard."""

from typing import ClassVar

from bt_manip.bt.blackboard import EMPTY
from bt_manip.bt.nodes.action import SyncAction
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.port_types import ANY, STRING, UNTYPED
from bt_manip.bt.ports import InOut, Input, is_pointer
from bt_manip.bt.status import FAILURE, SUCCESS, NodeStatus
from bt_manip.bt.traits import SUCCEEDS, YES_OR_NO
from bt_manip.exceptions import BlackboardError


class SetBlackboard(SyncAction):
    """Write a text, or the value and the type of another entry, to an entry.

    A text becomes the type of the entry, if that has one.

    | tick | SUCCESS; FAILURE if the other entry was never written; a value that does not      |
    |      | become the entry's type is an error of the tree                                    |
    |------|------------------------------------------------------------------------------------|
    | halt | nothing                                                                            |
    """

    traits: ClassVar = YES_OR_NO

    value = Input(doc="a text, or {key} for the value of another entry")
    output_key = InOut(doc="name of the entry, or {key} for an entry that holds the name")

    def _tick(self) -> NodeStatus:
        key = self.read_port("output_key", STRING)
        text = self.port_text("value")
        if text is None:
            raise self._port_error("value", "nothing was given")
        scope = self.scope
        target = scope.entry(key)
        if is_pointer(text):
            name = text.strip(" ")[1:-1]
            source = scope.entry(name)
            if source is None:
                raise BlackboardError(f"no entry '{name}' to copy")
            if target is None:
                target = scope.declare(key, source.declared)
            if source.value is EMPTY:
                self._because(f"entry '{name}' was never written")
                return FAILURE
            value, type = source.value, source.type
        else:
            value, type = text, STRING
        if type.family == "string" and target is not None and target.declared is not STRING:
            declared = target.declared
            if declared.converter is not None:
                try:
                    value, type = declared.converter(value), declared
                except ValueError as error:
                    raise BlackboardError(f"entry '{key}': {error}") from None
        local = scope if key[:1] != "@" else scope.root
        found = local.entries.get(key.lstrip("@"))
        if found is None:
            local.declare(key.lstrip("@"), type).put(value, type)
        elif not found.declared.strong:
            if type is not STRING or found.declared is not UNTYPED:
                found.declared = ANY
            found.put(value, type)
        elif found.declared != type:
            raise BlackboardError(
                f"entry '{key}' holds {found.declared.name}; it does not take {type.name}"
            )
        else:
            found.put(value, type)
        return SUCCESS


class UnsetBlackboard(SyncAction):
    """Remove an entry from the scope of this very tree.

    | tick | SUCCESS, whether there was one or not |
    |------|---------------------------------------|
    | halt | nothing                               |
    """

    traits: ClassVar = SUCCEEDS

    key = Input(str, doc="name of the entry")

    def _tick(self) -> NodeStatus:
        self.scope.unset(self.key)
        return SUCCESS


class Watching(Node):
    """The part of a node that checks whether the entry of its port ``entry`` was written."""

    checked_port = "entry"
    _seen = 0

    def check_ports(self) -> None:
        """Raise a `PortError` if the entry is not named."""
        if not self.given.get("entry"):
            raise self._port_error("entry", "nothing was given; expected {key}")

    def _was_updated(self) -> bool:
        """Check whether the entry was written since the last call; a missing one was not."""
        text = str(self.given["entry"]).strip(" ")
        entry = self.scope.entry(text[1:-1] if is_pointer(text) else text)
        if entry is None:
            return False
        seen = self._seen
        self._seen = entry.sequence
        return seen != entry.sequence


class WasEntryUpdated(Watching, SyncAction):
    """Succeed if an entry was written since the last check.

    | tick | SUCCESS if it was, else FAILURE; a missing entry was not written |
    |------|------------------------------------------------------------------|
    | halt | nothing                                                          |
    """

    memory: ClassVar = ("_seen",)
    traits: ClassVar = YES_OR_NO
    entry = Input(ANY, doc="the entry that is watched")

    def _tick(self) -> NodeStatus:
        if self._was_updated():
            return SUCCESS
        self._because(f"{self.given['entry']} was not written since")
        return FAILURE
