"""Placeholders for behaviours of which only the name and the ports are known."""

import keyword
import re
from collections.abc import Iterable
from typing import Any, ClassVar, Final

from bt_manip.bt.nodes.action import Action, Condition
from bt_manip.bt.nodes.node import Node, NodeKind
from bt_manip.bt.nodes.parent import Control, Decorator
from bt_manip.bt.nodes.tree_node import TreeNode
from bt_manip.bt.ports import InOut, Input, Output, Port
from bt_manip.bt.status import NodeStatus, Status
from bt_manip.exceptions import TreeError

RESULTS: Final = {"SUCCESS": "succeeds", "FAILURE": "fails", "RUNNING": "keeps running"}
"""Results of a stub, and the words for them."""


class Declared:
    """Marks the classes that `declare` makes.

    Attributes:
        effect: The effect of a tick in words.
        declaration: The arguments of `declare`, by name.
    """

    effect: ClassVar[str] = ""
    declaration: ClassVar[dict[str, Any]] = {}
    can_run: ClassVar[bool] = True


class _StubAction(Action):
    result: ClassVar = Status.SUCCESS

    def update(self) -> Status:
        self.feedback_message = f"a stub of {self.registration}"
        return self.result


class _StubCondition(Condition):
    result: ClassVar = Status.SUCCESS

    def update(self) -> Status:
        return self.result


class _StubControl(Control):
    can_run: ClassVar = False

    def _tick(self) -> NodeStatus:
        raise TreeError(cannot_run(self))


class _StubDecorator(Decorator):
    can_run: ClassVar = False

    def _tick(self) -> NodeStatus:
        raise TreeError(cannot_run(self))


_BASES: Final[dict[str, type[Node]]] = {
    NodeKind.ACTION: _StubAction,
    NodeKind.CONDITION: _StubCondition,
    NodeKind.CONTROL: _StubControl,
    NodeKind.DECORATOR: _StubDecorator,
}
LEAVES: Final = (NodeKind.ACTION, NodeKind.CONDITION)


def declare(
    name: str,
    kind: str = "Action",
    ports: Iterable[str | Port] = (),
    *,
    result: str = "SUCCESS",
    like: type[Node] | None = None,
) -> Any:
    """Make a class for a node of which only the name and the ports are known.

    A leaf succeeds, fails or keeps running, as `result` says. A control or decorator can be
    written, drawn and converted; it can be ticked only if `like` names a class with its rules.

    Args:
        name: Its name in documents.
        kind: ``Action``, ``Condition``, ``Control`` or ``Decorator``.
        ports: Its ports; a port that is given by its name is read and written, and optional.
        result: ``SUCCESS``, ``FAILURE`` or ``RUNNING``, for a leaf.
        like: A class that does its work, whose ports it has besides.

    Returns:
        A subclass of `Action`, `Condition`, `Control` or `Decorator`.

    Raises:
        TreeError: If the kind or the result is none of these, or `like` is of another kind.
    """
    base = like or _BASES.get(kind)
    if base is None:
        raise TreeError(f"'{name}': a node is one of {', '.join(_BASES)}, not '{kind}'")
    if (base.kind in LEAVES) != (kind in LEAVES) or (kind not in LEAVES and base.kind != kind):
        raise TreeError(f"'{name}' is a {kind}; {base.registration} is a {base.kind}")
    if result not in RESULTS or (kind == NodeKind.CONDITION and result == "RUNNING"):
        raise TreeError(f"'{name}': a stub of a {kind} cannot return '{result}'")
    if like is not None:
        effect = f"is a {like.registration}"
    else:
        effect = RESULTS[result] if kind in LEAVES else "only declared"
    found = [port if isinstance(port, Port) else _named(InOut, port) for port in ports]
    declaration = {"kind": kind, "ports": [p.name for p in found], "result": result, "like": like}
    members: dict[str, Any] = {
        "registration": name,
        "__doc__": f"Stand for {name}, which is only declared.",
        "__module__": __name__,
        "effect": effect,
        "declaration": declaration,
        "can_run": getattr(base, "can_run", True),
    }
    if like is None and kind in LEAVES:
        members["result"] = Status[result]
    cls = type(re.sub(r"\W", "_", name), (Declared, base), members)
    # Not as attributes: a port may be called "path" or "status", as those of py_trees are.
    own = {port.name: port for port in found}
    cls.ports = {**own, **base.ports}  # type: ignore[attr-defined]
    return cls


def _named(direction: type[Port], name: str, default: str | None = None, doc: str = "") -> Port:
    port = direction(default=default, doc=doc, name=name)
    port.attribute = re.sub(r"\W", "_", name) + "_" * keyword.iskeyword(name)
    return port


def model_port(direction: str, name: str, default: str | None, doc: str = "") -> Port:
    """Make an optional port, ``input``, ``output`` or ``inout``, from the model of a node."""
    kinds: dict[str, type[Port]] = {"input": Input, "output": Output}
    return _named(kinds.get(direction, InOut), name, default, doc)


def cannot_run(node: TreeNode) -> str:
    """Return why a declared control or decorator cannot be ticked, and the remedy."""
    kind = str(node.kind).lower()
    known = "Fallback" if node.kind is NodeKind.CONTROL else "RetryUntilSuccessful"
    return (
        f"'{node.registration}' is only declared: what the {kind} does is not known; "
        f'name one that does the same, as in --stub "{node.registration}={known}"'
    )
