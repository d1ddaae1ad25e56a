"""The names of kinds of nodes and of scripts, and those that no port can have."""

from enum import StrEnum
from typing import Final

from bt_manip.bt.ports import Port


class NodeKind(StrEnum):
    """What a node is, by the names of the elements of a tree document."""

    ACTION = "Action"
    CONDITION = "Condition"
    CONTROL = "Control"
    DECORATOR = "Decorator"
    SUBTREE = "SubTree"


CONDITIONS: Final = {
    "failure_if": "_failureIf",
    "success_if": "_successIf",
    "skip_if": "_skipIf",
    "while_true": "_while",
    "on_success": "_onSuccess",
    "on_failure": "_onFailure",
    "post": "_post",
    "on_halted": "_onHalted",
}
"""The scripts around a tick: their keyword in Python and their attribute in a document."""

RESERVED: Final = frozenset({"name", "ID", "_autoremap", *CONDITIONS.values()})
"""Names that are never ports."""


def refuse_reserved(cls: type, attribute: str, port: Port) -> None:
    """Refuse a port with a name that py_trees or the tree language needs.

    Args:
        cls: The class that declares it.
        attribute: Its name in Python.
        port: The port.

    Raises:
        TypeError: If the name is taken.
    """
    inside = {"name", "id", "status", "parent", "children", "logger", "feedback_message"} | {
        "blackboards", "blackbox_level", "iterator", "qualified_name", "attributes", "conditions",
        "decorated", "current_child",
    }  # fmt: skip
    taken = attribute in inside or any(
        attribute in vars(base) and not isinstance(vars(base)[attribute], Port)
        for base in cls.__mro__
    )
    if taken or attribute in CONDITIONS:
        raise TypeError(f"{cls.__name__}.{attribute}: a port cannot be named '{attribute}'")
    if port.name in RESERVED or not port.name[:1].isalpha():
        raise TypeError(f"{cls.__name__}.{attribute}: a port cannot be named '{port.name}'")
