"""SetBlackboard, UnsetBlackboard and WasEntryUpdated."""

from typing import ClassVar

from bt_manip.bt.blackboard import EMPTY
from bt_manip.bt.nodes.action import SyncAction
from bt_manip.bt.nodes.watching import Watching
from bt_manip.bt.port_types import ANY, STRING, UNTYPED
from bt_manip.bt.ports import InOut, Input, is_pointer
from bt_manip.bt.status import FAILURE, SUCCESS, NodeStatus
from bt_manip.exceptions import BlackboardError


class SetBlackboard(SyncAction):
    """Write a text, or the value and the type of another entry, to an entry.

    A text becomes the type of the entry, if that has one.

    | tick | SUCCESS; FAILURE if the other entry was never written; a value that is none of the |
    |      | entry's type is an error of the tree                                               |
    |------|------------------------------------------------------------------------------------|
    | halt | nothing                                                                            |
    """

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

    key = Input(str, doc="name of the entry")

    def _tick(self) -> NodeStatus:
        self.scope.unset(self.key)
        return SUCCESS


class WasEntryUpdated(Watching, SyncAction):
    """Succeed if an entry was written since the last look.

    | tick | SUCCESS if it was, else FAILURE; a missing entry was not written |
    |------|------------------------------------------------------------------|
    | halt | nothing                                                          |
    """

    memory: ClassVar = ("_seen",)
    entry = Input(ANY, doc="the entry that is watched")

    def _tick(self) -> NodeStatus:
        if self._was_updated():
            return SUCCESS
        self._because(f"{self.given['entry']} was not written since")
        return FAILURE
