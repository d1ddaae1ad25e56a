"""Write the package of a new plugin."""

import keyword
import re
from pathlib import Path

from bt_manip.exceptions import BtManipError
from bt_manip.models.bundled import bundled_root
from bt_manip.plugins.loading import load_plugins
from bt_manip.plugins.plugin import BUILTIN

KINDS = ("object", "controller", "robot", "behaviour", "planner")
"""What a new plugin can bring."""

_NAME = re.compile(r"[a-z][a-z0-9]*([-_][a-z0-9]+)*")
_LONGEST = 24  # letters, with which the lines of the templates stay short enough
_PLACEHOLDER = re.compile("bt-manip-gear|bt_manip_gear|Gear|gear")


def write_plugin(name: str, kind: str, parent: Path) -> Path:
    """Write a package that installs, lints and passes its tests at once.

    The templates are such packages themselves, of a part that is called gear.

    Args:
        name: Name of the plugin, in lower case with ``-`` between words.
        kind: What it brings, one of `KINDS`.
        parent: Folder in which the package's own is made.

    Returns:
        The package's folder, ``bt-manip-NAME``.

    Raises:
        BtManipError: When the name is none, or taken, or there is such a folder already.
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name) or len(name) > _LONGEST:
        raise BtManipError(
            f"the name of a plugin is made of small letters and digits, with '-' between words, "
            f"and at most {_LONGEST} long, got '{name}'"
        )
    words = re.split("[-_]", name)
    names = {
        "bt-manip-gear": f"bt-manip-{'-'.join(words)}",
        "bt_manip_gear": f"bt_manip_{'_'.join(words)}",
        "Gear": "".join(word.capitalize() for word in words),
        "gear": "_".join(words),
    }
    _check_free(names["Gear" if kind == "behaviour" else "gear"], kind)
    folder = parent / names["bt-manip-gear"]
    if folder.exists():
        raise BtManipError(f"there is a '{folder}' already")

    def filled(text: str) -> str:
        return _PLACEHOLDER.sub(lambda match: names[match[0]], text)

    template = bundled_root("templates") / kind
    for path in sorted(template.rglob("*")):
        place = path.relative_to(template)
        if path.is_file() and not any(p.startswith((".", "__pycache__")) for p in place.parts):
            new = folder / filled(place.as_posix())
            new.parent.mkdir(parents=True, exist_ok=True)
            new.write_text(filled(path.read_text(encoding="utf-8")), encoding="utf-8")
    return folder


def _check_free(name: str, kind: str) -> None:
    """Refuse a name that a plugin of this name could not register."""
    if name == BUILTIN:
        raise BtManipError(f"a plugin cannot be called '{BUILTIN}'")
    load_plugins(entry_points=()).parts.by_kind()[f"{kind}s"].check(name)
    if kind == "behaviour":
        from bt_manip.bt import BehaviourRegistry

        if name in BehaviourRegistry().names():
            raise BtManipError(f"'{name}' is a node of the tree language already")
