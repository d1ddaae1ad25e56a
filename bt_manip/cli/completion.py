"""Shell completion of registered names and of the keys of trees."""

import ast
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from bt_manip.cli.plugin_options import chosen
from bt_manip.exceptions import BtManipError

if TYPE_CHECKING:
    from bt_manip.cli.name_cache import NameCache
    from bt_manip.plugins import Plugins

Items = list[CompletionItem]
Complete = Callable[[click.Context, click.Parameter, str], Items]


def complete_part(kind: str) -> Complete:
    """Return a completion of the names of a kind of parts, or of files if no name fits.

    Args:
        kind: A kind of parts, as in ``bt-manip list KIND``.
    """

    def complete(ctx: click.Context, _: click.Parameter, incomplete: str) -> Items:
        names = _matching(_names(ctx, kind), incomplete)
        return names or [CompletionItem(incomplete, type="file")]

    return complete


def complete_kind(ctx: click.Context, _: click.Parameter, incomplete: str) -> Items:
    """Complete the KIND or NAME of ``bt-manip list``; names once no kind fits."""
    kinds = _matching(_kinds(ctx), incomplete)
    if kinds or not incomplete:
        return kinds
    return _matching(_cache(ctx).get("all names", lambda: _all_names(ctx)), incomplete)


def complete_listed(ctx: click.Context, _: click.Parameter, incomplete: str) -> Items:
    """Complete the NAME of ``bt-manip list KIND NAME``."""
    kind = ctx.params.get("kind")
    return _matching(_names(ctx, kind), incomplete) if kind in _kinds(ctx) else []


def complete_model_caches(ctx: click.Context, _: click.Parameter, incomplete: str) -> Items:
    """Complete the SOURCE of ``bt-manip models list SOURCE``."""
    return _matching(("bundled", *_names(ctx, "model_caches")), incomplete)


def complete_key(ctx: click.Context, _: click.Parameter, incomplete: str) -> Items:
    """Complete the KEY of ``--set KEY=VALUE`` with the keys of the tree before it."""
    # With an option whose value is still missing, click leaves the arguments unread.
    tree = ctx.params.get("tree") or next(iter(ctx.args), None)
    if tree is None or "=" in incomplete:
        return []
    try:
        place = tree if tree in _names(ctx, "trees") else os.path.abspath(tree)
        keys = _cache(ctx).get(f"keys of {place}", lambda: _keys(tree, _plugins(ctx)))
    except BtManipError:  # reported when the command runs
        return []
    return _matching((f"{key}=" for key in keys), incomplete)


def listed(plugins: "Plugins") -> tuple[str, ...]:
    """Return the kinds of parts that can be listed."""
    return (*plugins.parts.by_kind(), "plugins")


def part_names(plugins: "Plugins", kind: str) -> list[str]:
    """Return the names of all parts of a kind, of all nodes of the language for behaviours."""
    kind = "trees" if kind == "tasks" else kind
    if kind == "plugins":
        return [plugin.name for plugin in plugins.plugins]
    if kind == "behaviours":
        from bt_manip.runner import known_behaviours

        return list(known_behaviours(plugins.parts).names())
    return list(plugins.parts.by_kind()[kind].names())


def _kinds(ctx: click.Context) -> list[str]:
    return _cache(ctx).get("kinds", lambda: ([*listed(_plugins(ctx))], ()))


def _names(ctx: click.Context, kind: str) -> list[str]:
    """Return the names of all parts of a kind, from the cache where it is valid."""
    return _cache(ctx).get(kind, lambda: (part_names(_plugins(ctx), kind), ()))


def _all_names(ctx: click.Context) -> tuple[list[str], tuple[()]]:
    plugins = _plugins(ctx)
    return sorted({name for kind in listed(plugins) for name in part_names(plugins, kind)}), ()


def _keys(tree: str, plugins: "Plugins") -> tuple[list[str], list[Path]]:
    """Return the keys of a tree and its files; a Python file is parsed and not run."""
    from bt_manip.bt import read_tree
    from bt_manip.runner import find_tree, known_behaviours

    trees = plugins.parts.trees
    source = find_tree(tree, trees.copies())
    if source.path is None:
        return [], []
    if source.kind == "python":
        function = function_in(source.path, source.function)
        arguments = [*function.args.args, *function.args.kwonlyargs] if function else []
        return [argument.arg for argument in arguments], [source.path]
    found = read_tree(source.path, known_behaviours(plugins.parts)).tree
    if found is None or found.document is None:
        return [], [source.path]
    return list(found.document.models.get(found.tree_id, ())), found.document.files


def function_in(path: Path, name: str) -> ast.FunctionDef | None:
    """Return a function of a file that is parsed and not run; None if there is none."""
    try:
        body = ast.parse(path.read_bytes()).body
    except (OSError, SyntaxError, ValueError):
        return None
    functions = (node for node in body if isinstance(node, ast.FunctionDef))
    return next((node for node in functions if node.name == name), None)


def _plugins(ctx: click.Context) -> "Plugins":
    """Load the chosen plugins silently: the shell shows nothing but the names."""
    os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.plugins import load_plugins

    return load_plugins(warn=lambda _: None, choice=chosen(ctx))


def _cache(ctx: click.Context) -> "NameCache":
    from bt_manip.cli.name_cache import NameCache

    return NameCache(chosen(ctx))


def _matching(names: Iterable[str], incomplete: str) -> Items:
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]
