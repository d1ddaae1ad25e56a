"""Replacing a running tree between two ticks."""

from typing import TYPE_CHECKING

from bt_manip.bt.blackboard import Blackboard

if TYPE_CHECKING:
    from bt_manip.bt.tree import Tree


def replace(tree: "Tree", other: "Tree") -> None:
    """Let `tree` go on as `other`.

    What runs is halted. The entries of every scope that both trees have stay, with those that only
    the new tree declares added. Observers and infrastructure stay.

    Args:
        tree: The tree that runs.
        other: A tree that has not run; it must not be used afterwards.

    Raises:
        NodeError: If a behaviour of the new tree fails in its ``setup``; the old tree is halted
            then, and stays.
    """
    tree.halt()
    if tree._infrastructure is not None:
        other.setup(**tree._infrastructure)
    runtime = tree._runtime
    for path, scope in other.scopes.items():
        old = tree.scopes.get(path)
        if old is not None:
            _keep_entries(old, scope)
    runtime.timers.clear()
    runtime.wake_up = False
    runtime.reason = None
    runtime.enums.update(other._runtime.enums)
    tree.root = other.root
    tree.tree_id = other.tree_id
    tree.document = other.document
    tree.nodes = other.nodes
    tree.scopes = other.scopes
    tree._root = other._root
    for link in tree.nodes:
        link._node_runtime = runtime
        link._node_observers = runtime.observers


def _keep_entries(old: Blackboard, new: Blackboard) -> None:
    """Keep what was written, unless the new tree gives the key another type or meaning."""
    for key, entry in old.entries.items():
        fresh = new.entries.get(key)
        if key in new.remapped:
            continue
        if fresh is None:
            new.entries[key] = entry
        elif fresh.sequence == 0 and (
            not fresh.declared.strong
            or fresh.declared == entry.declared
            or not entry.declared.strong
        ):
            new.entries[key] = entry
