"""Trees that a document describes, and the keys that it lets one set."""

from collections.abc import Callable, Mapping

from bt_manip.bt import STRING, BehaviourRegistry, ReadingOptions, Tree, read_tree
from bt_manip.exceptions import BlackboardError, BtManipError, did_you_mean, shown
from bt_manip.registry import Parts

from .tree_source import Clock, TreeSource

READING = ReadingOptions(dialect="auto")
"""How the documents of runs are read by default."""

Warn = Callable[[str], None]


def load_document(
    source: TreeSource,
    parts: Parts,
    settings: Mapping[str, str],
    clock: Clock,
    warn: Warn,
    *,
    reading: ReadingOptions = READING,
) -> Tree:
    """Read a tree and give its keys their values; warn of what is strange without being wrong.

    What one may set is what the document's ``<TreeNodesModel>`` lists as input ports of the main
    tree, as it would list them for a sub-tree: with a default, or without where it must be given. A
    wrong document and a setting that does not fit raise a `BtManipError`.
    """
    assert source.path is not None
    main = source.function or reading.main
    found = read_tree(source.path, known_behaviours(parts), reading, clock=clock, main=main)
    for warning in found.warnings:
        warn(str(warning))
    tree = found.usable_tree()
    set_keys(source, tree, settings)
    return tree


def known_behaviours(parts: Parts) -> BehaviourRegistry:
    """Return the nodes of the language and all registered behaviours and dialects."""
    behaviours = BehaviourRegistry()
    for name in parts.behaviours.names():
        behaviours.register(parts.behaviours.get(name), name)
    for dialect in parts.dialects.copies().values():
        behaviours.register_dialect(dialect)
    return behaviours


def set_keys(
    source: TreeSource, tree: Tree, settings: Mapping[str, str], *, only_new: bool = False
) -> None:
    """Give the keys that a document declares their values: settings, or else defaults.

    With `only_new`, keys that have a value keep it. A setting that does not fit raises a
    `BtManipError`.
    """
    assert tree.document is not None
    keys = tree.document.models.get(tree.tree_id, {})
    for key in settings:
        if key not in keys:
            near = did_you_mean(key, keys)
            raise BtManipError(f"the tree '{source.name}' has no key '{key}'{near}")
    for key, default in keys.items():
        if only_new and key in tree.blackboard:
            continue
        text = settings.get(key, default)
        if text is None:
            raise BtManipError(
                f"the tree '{source.name}' needs --set {key}=VALUE: it has no default"
            )
        # As the type that the ports which read it have declared.
        entry = tree.blackboard.entry(key)
        if entry is None or not entry.declared.strong:
            tree.blackboard.set_text(key, text)
            continue
        kind = entry.declared
        try:
            if kind.ignored_rest(text):
                raise BlackboardError("it is cut")
            tree.blackboard.write(key, text, STRING)
        except BlackboardError:
            raise BtManipError(f"--set {key}: expected {kind.form}, got {shown(text)}") from None
