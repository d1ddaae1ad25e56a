"""A tree inside a tree, with a blackboard scope of its own."""

from collections.abc import Mapping
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.literals import parse_boolean
from bt_manip.bt.nodes.node import CONDITIONS, RESERVED, NodeKind
from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.ports import is_pointer
from bt_manip.bt.status import FAILURE, IDLE, SUCCESS, NodeStatus
from bt_manip.exceptions import PortError


class SubTree(Decorator):
    """Tick the root of another tree, in a blackboard scope of its own.

    | child | result                                            |
    |-------|---------------------------------------------------|
    | any   | SUCCESS, FAILURE, RUNNING and SKIPPED as they are |
    | halt  | the child is halted                               |

    The keys of the outer scope that the inner tree may see are given as remaps:
    ``target="{cube}"`` lets ``{target}`` inside mean ``{cube}`` outside; any other value is a
    constant of the inner scope.

    Args:
        *args: Optionally its name, then the root of the inner tree.
        child: The root of the inner tree.
        tree_id: The ID of the inner tree in a document; the name if none is given.
        remap: The meaning of the inner keys: ``"{outer key}"``, or a constant.
        autoremap: Whether all other keys mean the same outside; also as text, ``"true"``.
        **remaps: More of `remap`, and the scripts around the tick.
    """

    kind: ClassVar = NodeKind.SUBTREE

    def __init__(
        self,
        *args: Any,
        child: Behaviour | None = None,
        tree_id: str | None = None,
        remap: Mapping[str, str] | None = None,
        autoremap: bool | str = False,
        **remaps: Any,
    ) -> None:
        scripts = {key: remaps.pop(key) for key in list(remaps) if key in CONDITIONS}
        super().__init__(*args, child=child, **scripts)
        self.is_unnamed = not self.is_named
        self.tree_id = tree_id or self.name
        if self.is_unnamed:
            self.name = self.tree_id
        self.autoremap_text = autoremap if isinstance(autoremap, str) else ("", "true")[autoremap]
        self.autoremap = bool(self.autoremap_text) and parse_boolean(self.autoremap_text)
        self.remaps: dict[str, str] = {}
        for key, value in {**(remap or {}), **remaps}.items():
            if key in RESERVED or not key[:1].isalpha():
                raise PortError(f"sub-tree {self.name}: '{key}' cannot be remapped")
            self.remaps[key] = str(int(value)) if isinstance(value, bool) else str(value)

    def make_scope(self, outer: Blackboard) -> Blackboard:
        """Make the inner scope, with its remaps and constants."""
        scope = Blackboard(outer)
        for key, text in self.remaps.items():
            text = f"{{{key}}}" if text == "{=}" else text
            if is_pointer(text):
                scope.remap(key, text.strip(" ")[1:-1])
            else:
                scope.set_text(key, text)
        scope.autoremap = self.autoremap
        self.inner_scope = scope
        return scope

    def _tick(self) -> NodeStatus:
        if self._node_status is IDLE:
            self._enter()
        state = self.child_node.execute()
        if state is SUCCESS or state is FAILURE:
            self._reset_child()
        return state
