"""Findings of the check of a tree, at the nodes that they are about."""

from bisect import bisect_right
from collections.abc import Iterable
from typing import Any

from bt_manip.bt import Tree
from bt_manip.files import read_text

Findings = dict[str, list[tuple[str, str]]]
"""Severity and message of each finding at a node, by the uid of the node."""


def findings_at_nodes(tree: Tree, problems: Iterable[Any]) -> Findings:
    """Return the findings of a document, each at the nodes in whose element it lies.

    Findings in no element of a node are at the root, with their places.

    Args:
        tree: The tree.
        problems: The findings, as of `Tree.warnings`: of the document as it was read, or edited
            with all lines where they were.
    """
    found: Findings = {}
    if not (problems := tuple(problems)) or tree.document is None:
        return found
    starts = sorted(one.place for top in tree.document.trees.values() for one in top.iterate())
    places = tree.places()
    for problem in problems:
        start = starts[bisect_right(starts, problem.place) - 1]
        is_near = start.file == problem.place.file
        uids = [str(one.uid) for one in tree if is_near and places[one.path] == str(start)]
        text = problem.message if uids else f"{problem.place}: {problem.message}"
        for uid in uids or [str(tree.nodes[0].uid)]:
            found.setdefault(uid, []).append((problem.severity, text))
    return found


def count_lines(tree: Tree) -> dict[str, int]:
    """Return the number of lines in each file of a tree, as far as it can be read now."""
    counts = {}
    for path in [] if tree.document is None else tree.document.files:
        try:
            counts[str(path)] = read_text(path).count("\n")
        except (OSError, UnicodeDecodeError):
            counts[str(path)] = -1
    return counts
