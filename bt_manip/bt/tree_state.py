"""The state of a tree as plain data, for snapshots."""

from collections.abc import Mapping
from typing import Any

from bt_manip.bt import port_types
from bt_manip.bt.blackboard import EMPTY, Blackboard, Entry
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.tree_node import TreeNode
from bt_manip.bt.port_types import PortType
from bt_manip.bt.runtime import Runtime
from bt_manip.bt.status import PY_STATUS, NodeStatus
from bt_manip.exceptions import TreeError


def get_tree_state(
    nodes: list[TreeNode], scopes: Mapping[str, Blackboard], runtime: Runtime
) -> dict[str, Any]:
    """Return the state as plain data; raise a `TreeError` if a value cannot be written as text."""
    return {
        "nodes": [
            {
                "path": node.path,
                "status": int(node._node_status),
                "feedback": node.feedback_message,
                "state": node.get_state(),
            }
            for node in nodes
        ],
        "scopes": {
            path: {key: _entry_state(key, entry) for key, entry in scope.entries.items()}
            for path, scope in scopes.items()
        },
        "wake_up": runtime.wake_up,
        "reason": runtime.reason,
    }


def set_tree_state(
    state: Mapping[str, Any],
    nodes: list[TreeNode],
    scopes: Mapping[str, Blackboard],
    runtime: Runtime,
) -> None:
    """Restore what `get_tree_state` returned; raise a `TreeError` if it is of another tree."""
    if [entry["path"] for entry in state["nodes"]] != [node.path for node in nodes]:
        raise TreeError("the state is of another tree: its nodes have other paths")
    types = _known_types(nodes)
    for path, entries in state["scopes"].items():
        scope = scopes[path]
        scope.entries = {key: _entry(key, entry, types) for key, entry in entries.items()}
    runtime.timers.clear()
    runtime.reason = state["reason"]
    for node, entry in zip(nodes, state["nodes"], strict=True):
        node._node_status = NodeStatus(entry["status"])
        node.set_state(entry["state"])
        if isinstance(node, Node):
            node.status = PY_STATUS[entry["status"]]
            node.feedback_message = entry["feedback"]
    runtime.wake_up = state["wake_up"]


def _entry_state(key: str, entry: Entry) -> dict[str, Any]:
    state: dict[str, Any] = {"declared": entry.declared.name, "sequence": entry.sequence}
    if entry.value is not EMPTY:
        state["type"] = entry.type.name
        state["value"] = _plain(key, entry.value, entry.type)
    return state


def _plain(key: str, value: Any, type: PortType) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if type.format is not None:
        return {"text": type.format(value)}
    if isinstance(value, list) and all(
        isinstance(item, bool | int | float | str) for item in value
    ):
        return list(value)
    raise TreeError(f"entry '{key}' holds a {type.name}, which cannot be written as text")


def _entry(key: str, state: Mapping[str, Any], types: Mapping[str, PortType]) -> Entry:
    try:
        entry = Entry(types[state["declared"]])
        entry.sequence = state["sequence"]
        if "type" in state:
            entry.type = types[state["type"]]
            value = state["value"]
            if isinstance(value, dict):
                assert entry.type.parse is not None
                value = entry.type.parse(value["text"])
            entry.value = list(value) if isinstance(value, list) else value
    except KeyError as error:
        raise TreeError(
            f"entry '{key}' has a type that no node of the tree knows: {error}"
        ) from None
    return entry


def _known_types(nodes: list[TreeNode]) -> dict[str, PortType]:
    types = {
        value.name: value for value in vars(port_types).values() if isinstance(value, PortType)
    }
    of_ports = (port.type for node in nodes for port in node.ports.values())
    of_values = map(port_types.port_type, (list, type(None)))  # of what a program wrote
    for one in (*of_ports, *of_values):
        types.setdefault(one.name, one)
    return types
