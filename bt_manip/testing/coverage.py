"""Coverage of trees by tests: ticked leaves, and results of nodes."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from bt_manip.bt import NodeStatus, Tree

if TYPE_CHECKING:
    from bt_manip.bt.nodes import TreeNode


_ENDS = (NodeStatus.SUCCESS, NodeStatus.FAILURE)
_ONE_END = {
    "AlwaysSuccess": NodeStatus.SUCCESS,
    "AlwaysFailure": NodeStatus.FAILURE,
    "ForceSuccess": NodeStatus.SUCCESS,
    "ForceFailure": NodeStatus.FAILURE,
    "Script": NodeStatus.SUCCESS,
    "SetBlackboard": NodeStatus.SUCCESS,
    "Sleep": NodeStatus.SUCCESS,
    "UnsetBlackboard": NodeStatus.SUCCESS,
}
"""Nodes of the language with a single possible result."""


class Covered(NamedTuple):
    """Coverage of one tree."""

    leaves: int  # ticked
    leaves_all: int
    branches: int  # results seen
    branches_all: int
    missing: tuple[str, ...]  # "path: never ticked", "path: never FAILURE"


@dataclass
class _Node:
    path: str
    is_leaf: bool
    possible: tuple[NodeStatus, ...]
    ticked: bool = False
    ends: set[NodeStatus] = field(default_factory=set)


class TreeCoverage:
    """Collects coverage over runs of any number of trees.

    A leaf is covered if it was ticked. A branch is a result of a node, SUCCESS or FAILURE, and is
    covered if the node ended with it. Nodes of the language with a single possible result have one
    branch. Runs of the same tree (same document, same ID) are added up.
    """

    def __init__(self) -> None:
        self._trees: dict[str, dict[str, _Node]] = {}

    def watch(self, tree: Tree) -> None:
        """Observe a tree."""
        document = f"{tree.source.name}:" if tree.source is not None else ""
        nodes = self._trees.setdefault(f"{document}{tree.tree_id}", {})
        for node in tree.nodes:
            if node.path not in nodes:
                ends = (_ONE_END[node.registration],) if node.registration in _ONE_END else _ENDS
                # A substituted node has no children.
                nodes[node.path] = _Node(node.path, not node.children, ends)

        def note(node: "TreeNode", old: NodeStatus, new: NodeStatus) -> None:
            if new is not NodeStatus.IDLE:
                seen = nodes[node.path]
                seen.ticked = True
                if new in _ENDS:
                    seen.ends.add(new)

        tree.observers.append(note)

    def of(self, tree: str) -> Covered:
        """Return the coverage of a tree that was observed."""
        nodes = list(self._trees[tree].values())
        leaves = [node for node in nodes if node.is_leaf]
        return Covered(
            sum(node.ticked for node in leaves),
            len(leaves),
            sum(len(node.ends & set(node.possible)) for node in nodes),
            sum(len(node.possible) for node in nodes),
            tuple(_missing(nodes)),
        )

    def lines(self) -> Iterator[str]:
        """Yield the lines of a table."""
        yield f"{'tree':40} {'leaves':>12} {'branches':>14}"
        for name in sorted(self._trees):
            seen = self.of(name)
            leaves = f"{seen.leaves}/{seen.leaves_all} {100 * seen.leaves / seen.leaves_all:.0f} %"
            share = 100 * seen.branches / seen.branches_all
            branches = f"{seen.branches}/{seen.branches_all} {share:.0f} %"
            yield f"{name:40} {leaves:>12} {branches:>14}"
            for missing in seen.missing:
                yield f"    {missing}"


def _missing(nodes: list[_Node]) -> Iterator[str]:
    for node in nodes:
        if not node.ticked:
            yield f"{node.path}: never ticked"
            continue
        for end in node.possible:
            if end not in node.ends:
                yield f"{node.path}: never {end.name}"
