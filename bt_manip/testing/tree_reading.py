"""Trees for tests, from a file or a registered name, with substituted nodes."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bt_manip.bt import ReadingOptions, Rule, Tree, find_rule
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Parts
from bt_manip.runner import find_tree, load_document, make_tree
from bt_manip.testing.stubs import Stub

Substitute = Mapping[str, "Stub | Rule"]
"""What stands in for nodes, by their name, registered name or path (with ``* ?``): a `Stub`, the
name of another behaviour, or a rule of `bt_manip.bt.substitution`."""


def read_test_tree(
    text: str | Path,
    parts: Parts,
    clock: Callable[[], float],
    *,
    folder: Path | None = None,
    settings: Mapping[str, Any] | None = None,
    substitute: Substitute | None = None,
) -> Tree:
    """Read a tree for a test: a registered name, or a path in a folder, the current one by default.

    Nodes of documents can be substituted. Unknown and invalid trees, and a substitution that
    matches no node, raise a `BtManipError`.
    """
    source = find_tree(located(text, folder), parts.trees.copies())
    texts = {key: str(value) for key, value in (settings or {}).items()}
    if source.kind == "python":
        if substitute:
            raise ValueError(f"'{text}' is made by a function: build it with other leaves there")
        return make_tree(source, texts, clock)
    rules = {
        pattern: rule.config if isinstance(rule, Stub) else rule
        for pattern, rule in (substitute or {}).items()
    }

    def read(rules: Mapping[str, Rule]) -> Tree:
        options = ReadingOptions(dialect="auto", substitutions=rules)
        return load_document(source, parts, texts, clock, warn=lambda _: None, reading=options)

    tree = read(rules)
    idle = _idle(rules, tree)
    if idle:  # except for registered names, which a substituted node does not show
        tree_as_it_is = read({})
        for pattern in _idle(idle, tree_as_it_is):
            names = {n for node in tree_as_it_is.nodes for n in (node.name, node.registration)}
            raise BtManipError(
                f"substitute: no node of '{text}' is '{pattern}'{did_you_mean(pattern, names)}"
            )
    return tree


def located(text: str | Path, folder: Path | None = None) -> str:
    """Return the path of a tree that is relative to a folder; a registered name as it is."""
    path, colon, function = str(text).partition(":")
    beside = (folder or Path()) / path
    return f"{beside}{colon}{function}" if beside.is_file() else str(text)


def _idle(rules: Mapping[str, Rule], tree: Tree) -> Mapping[str, Rule]:
    """Return the rules that match no node of a tree."""
    return {
        pattern: rule
        for pattern, rule in rules.items()
        if not any(
            find_rule({pattern: pattern}, n.name, n.registration, n.path) for n in tree.nodes
        )
    }
