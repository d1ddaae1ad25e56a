"""How much of a tree tests have been through: its leaves, and the two ends of each node."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bt_manip.bt import NodeStatus, Tree

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
"""Nodes of the language that can end in one way only."""


class Covered(NamedTuple):
    """How much of a tree was seen."""

    leaves: int  # ticked
    leaves_all: int
    branches: int  # ends seen
    branches_all: int
    missing: tuple[str, ...]  # "path: never ticked", "path: never FAILURE"

    @property
    def leaf_share(self) -> float:
        """Share of the leaves that were ticked."""
        return self.leaves / self.leaves_all if self.leaves_all else 1.0

    @property
    def branch_share(self) -> float:
        """Share of the ends of nodes that were seen."""
        return self.branches / self.branches_all if self.branches_all else 1.0


@dataclass
class _Node:
    path: str
    is_leaf: bool
    possible: tuple[NodeStatus, ...]
    ticked: bool = False
    ends: set[NodeStatus] = field(default_factory=set)


class TreeCoverage:
    """Gathers what is ticked, over as many runs of as many trees as there are.

    A leaf is covered when it was ticked. A branch is one of the two ends of a node, SUCCESS and
    FAILURE, and is covered when the node has ended so; nodes of the language that can only end in
    one way have one. Runs of the same tree add up: same document, same ID.
    """

    def __init__(self) -> None:
        """Begin with no trees."""
        self._trees: dict[str, dict[str, _Node]] = {}

    def watch(self, tree: Tree) -> None:
        """Take a tree in: whatever it does from now on counts."""
        nodes = self._trees.setdefault(_name(tree), {})
        for node in tree.nodes:
            if node.path not in nodes:
                ends = (_ONE_END[node.registration],) if node.registration in _ONE_END else _ENDS
                # A stand-in has taken the children away with the node.
                nodes[node.path] = _Node(node.path, not node.children, ends)

        def note(node: Any, old: NodeStatus, new: NodeStatus) -> None:
            if new is not NodeStatus.IDLE:
                seen = nodes[node.path]
                seen.ticked = True
                if new in _ENDS:
                    seen.ends.add(new)

        tree.observers.append(note)

    @property
    def trees(self) -> tuple[str, ...]:
        """Name the trees that were watched."""
        return tuple(self._trees)

    def of(self, tree: str) -> Covered:
        """Say how much of a tree was seen.

        Raises:
            KeyError: When no tree of this name was watched.
        """
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
        """Return a table as text."""
        yield f"{'tree':40} {'leaves':>12} {'branches':>14}"
        for name in sorted(self._trees):
            seen = self.of(name)
            leaves = f"{seen.leaves}/{seen.leaves_all} {100 * seen.leaf_share:.0f} %"
            branches = f"{seen.branches}/{seen.branches_all} {100 * seen.branch_share:.0f} %"
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


def _name(tree: Tree) -> str:
    source = tree.source
    return tree.tree_id if source is None else f"{source.name}:{tree.tree_id}"
