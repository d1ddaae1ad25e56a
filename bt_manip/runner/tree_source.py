"""Source of a tree, read from the argument of ``bt-manip run``."""

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.packages import missing

Clock = Callable[[], float]
"""Clock of a tree's timers [s]."""


@dataclass(frozen=True)
class TreeSource:
    """One tree, found but not yet read.

    Attributes:
        name: What the user wrote; reports and views show it.
        kind: ``"xml"``, or ``"python"`` for a function that returns a tree, or a tree itself.
        path: The file that holds it, or None if it is in an installed module.
        module: Name of the module that holds it, or None.
        function: Name of the function or tree; empty for the main tree of XML.
    """

    name: str
    kind: Literal["xml", "python"]
    path: Path | None = None
    module: str | None = None
    function: str = ""


_MODULE_FUNCTION = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*")


def find_tree(text: str, registered: Mapping[str, str]) -> TreeSource:
    """Find the tree that a user means.

    Args:
        text: A registered name, ``path.xml``, ``path.xml:tree``, ``path.py:name`` or
            ``package.module:name``.
        registered: Names of trees and where they are: ``path.xml`` or ``path.py:name``.

    Raises:
        BtManipError: When there is no such tree.
    """
    source = _from_place(text, registered.get(text, text))
    if source is not None:
        return source
    module, _, function = text.partition(":")
    if _MODULE_FUNCTION.fullmatch(text) and not module.endswith((".py", ".xml")):
        return TreeSource(text, "python", module=module, function=function)
    raise BtManipError(_not_found(text, registered))


def _from_place(name: str, place: str) -> TreeSource | None:
    if place.endswith(".xml") and Path(place).is_file():
        return TreeSource(name, "xml", path=Path(place))
    path, colon, function = place.rpartition(":")
    if function and path.endswith(".xml") and Path(path).is_file():
        return TreeSource(name, "xml", path=Path(path), function=function)
    if colon and path.endswith(".py") and function.isidentifier() and Path(path).is_file():
        return TreeSource(name, "python", path=Path(path), function=function)
    return None


def _not_found(text: str, registered: Mapping[str, str]) -> str:
    path, _, function = text.rpartition(":")
    if folder := next(filter(os.path.isdir, (text, path)), ""):
        return f"'{folder}' is a folder; a tree is a file, path.xml or path.py:name"
    file = path if path.endswith(".xml") else text
    if file.endswith(".xml"):
        return f"no tree file '{file}'" + _beside(Path(file), ".xml")
    if text.endswith(".py"):
        return f"'{text}' does not say which tree; write '{text}:NAME' of a function or tree in it"
    if path.endswith(".py") and not Path(path).is_file():
        what = f"no file '{path}' to take the tree '{function}' from"
        return what + _beside(Path(path), ".py")
    if package := missing("tree", text):
        return f"unknown tree '{text}'; it {package}"
    return (
        f"unknown tree '{text}'"
        + did_you_mean(text, registered)
        + " (a tree is a registered name, path.xml[:tree], path.py:name or package.module:name)"
    )


def _beside(path: Path, suffix: str) -> str:
    """Offer the files of the same kind that stand where the missing one should."""
    if not path.parent.is_dir():
        return f": no folder '{path.parent}'"
    return did_you_mean(path.name, [p.name for p in path.parent.glob(f"*{suffix}")])
