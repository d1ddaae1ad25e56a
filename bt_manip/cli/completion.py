"""Shell completion of registered names and of the keys of trees."""

import ast
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from bt_manip.cli.plugin_options import chosen

if TYPE_CHECKING:
    from bt_manip.plugins import Plugins

Items = list[CompletionItem]
Complete = Callable[[click.Context, click.Parameter, str], Items]


def complete_part(kind: str) -> Complete:
    """Return a completion of the names of a kind of parts, or of files if no name fits.

    Args:
        kind: A kind of parts, as in ``bt-manip list KIND``.
    """

    def complete(ctx: click.Context, _: click.Parameter, incomplete: str) -> Items:
        names = _matching(part_names(_plugins(ctx), kind), incomplete)
        return names or [CompletionItem(incomplete, type="file")]

    return complete


def complete_listed(
    ctx: click.Context, _: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the NAME of ``bt-manip list KIND NAME``."""
    kind = ctx.params.get("kind")
    return _matching(part_names(_plugins(ctx), kind), incomplete) if kind else []


def complete_model_caches(ctx: click.Context, _: click.Parameter, incomplete: str) -> Items:
    """Complete the SOURCE of ``bt-manip models list SOURCE``."""
    return _matching(("bundled", *_plugins(ctx).parts.model_caches), incomplete)


def complete_key(ctx: click.Context, _: click.Parameter, incomplete: str) -> Items:
    """Complete the KEY of ``--set KEY=VALUE`` with the keys of the tree before it."""
    from bt_manip.exceptions import BtManipError

    # With an option whose value is still missing, click leaves the arguments unread.
    tree = ctx.params.get("tree") or next(iter(ctx.args), None)
    if tree is None or "=" in incomplete:
        return []
    try:
        keys = _keys(tree, _plugins(ctx))
    except BtManipError:  # reported when the command runs
        return []
    return _matching((f"{key}=" for key in keys), incomplete)


def part_names(plugins: "Plugins", kind: str) -> list[str]:
    """Return the names of all parts of a kind, of all nodes of the language for behaviours."""
    kind = "trees" if kind == "tasks" else kind
    if kind == "plugins":
        return [plugin.name for plugin in plugins.plugins]
    if kind == "behaviours":
        from bt_manip.runner import known_behaviours

        return list(known_behaviours(plugins.parts).names())
    return list(plugins.parts.by_kind()[kind].names())


def _keys(tree: str, plugins: "Plugins") -> Iterable[str]:
    """Return the keys of a tree; a Python file is parsed and not run."""
    from bt_manip.bt import read_tree
    from bt_manip.runner import find_tree, known_behaviours

    trees = plugins.parts.trees
    source = find_tree(tree, {name: trees.get(name) for name in trees})
    if source.path is None:
        return ()
    if source.kind == "python":
        return _arguments(source.path, source.function)
    found = read_tree(source.path, known_behaviours(plugins.parts)).tree
    if found is None or found.document is None:
        return ()
    return found.document.models.get(found.tree_id, ())


def _arguments(path: Path, function: str) -> list[str]:
    try:
        body = ast.parse(path.read_bytes()).body
    except (OSError, SyntaxError, ValueError):
        return []
    functions = [n for n in body if isinstance(n, ast.FunctionDef) and n.name == function]
    arguments = [a for f in functions for a in (*f.args.args, *f.args.kwonlyargs)]
    return [argument.arg for argument in arguments]


def _plugins(ctx: click.Context) -> "Plugins":
    """Load the chosen plugins silently: the shell shows nothing but the names."""
    os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.plugins import load_plugins

    return load_plugins(warn=lambda _: None, choice=chosen(ctx))


def _matching(names: Iterable[str], incomplete: str) -> Items:
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]
