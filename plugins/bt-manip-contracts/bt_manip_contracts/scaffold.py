"""Creation of packages for new plugins from templates."""

import keyword
import re
import tokenize
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_manip.exceptions import BtManipError
from bt_manip.plugins import Plugins, load_plugins

_NAME = re.compile(r"[a-z][a-z0-9]*([-_][a-z0-9]+)*")
_LONGEST = 24  # letters, to keep lines of the templates short
_PLACEHOLDER = re.compile("bt-manip-gear|bt_manip_gear|Gear|gear")


_HERE = Path(__file__).resolve().parent
_PACKED = _HERE / "templates"  # in a wheel
_TEMPLATES = _PACKED if _PACKED.is_dir() else _HERE.parents[2] / "templates"

KINDS = sorted(path.parent.name for path in _TEMPLATES.glob("*/pyproject.toml"))
"""Kinds of parts for which there is a template."""


def write_plugin(name: str, kind: str, parent: Path, plugins: Plugins | None = None) -> Path:
    """Write a package for a plugin, ready to install, that passes its linter and tests.

    The templates are such packages with a part named ``gear``. The package is written atomically.

    Args:
        name: Name of the plugin, in lower case with ``-`` between words.
        kind: Kind of its part, the name of a template.
        parent: Folder in which the package's folder is created.
        plugins: Installed plugins, whose names are taken; default: only the built-in one.

    Returns:
        The package's folder, ``bt-manip-NAME``.

    Raises:
        BtManipError: If the name is invalid or taken, the folder exists, or it cannot be
            written.
    """
    words = re.split("[-_]", name)
    names = {
        "bt-manip-gear": f"bt-manip-{'-'.join(words)}",
        "bt_manip_gear": f"bt_manip_{'_'.join(words)}",
        "Gear": "".join(word.capitalize() for word in words),
        "gear": "_".join(words),
    }
    is_keyword = any(keyword.iskeyword(names[part]) for part in ("gear", "Gear"))
    if is_keyword or not _NAME.fullmatch(name) or len(name) > _LONGEST:
        raise BtManipError(
            f"the name of a plugin is made of small letters and digits, with '-' between words, "
            f"is at most {_LONGEST} long and no word of Python's own, got '{name}'"
        )
    template = _TEMPLATES / kind
    files = [path for path in sorted(template.rglob("*")) if _belongs(path, template)]
    part = names["Gear" if kind == "behaviour" else "gear"]
    _check_free(names["gear"], part, kind, plugins or load_plugins(entry_points=()))
    _check_unused(name, names, files)
    folder = parent / names["bt-manip-gear"]
    if folder.exists() or folder.is_symlink():
        raise BtManipError(f"there is a '{folder}' already")

    def filled(text: str) -> str:
        return _PLACEHOLDER.sub(lambda match: names[match[0]], text)

    try:
        parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=f".{folder.name}-", dir=parent) as unfinished:
            package = Path(unfinished) / folder.name
            for path in files:
                target = package / filled(path.relative_to(template).as_posix())
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text(filled(path.read_text(encoding="utf-8")), encoding="utf-8")
            package.rename(folder)
    except OSError as error:
        raise BtManipError(f"cannot write '{folder}': {error.strerror}") from error
    return folder


def _belongs(path: Path, template: Path) -> bool:
    parts = path.relative_to(template).parts
    return path.is_file() and not any(part.startswith((".", "__pycache__")) for part in parts)


def _check_free(name: str, part: str, kind: str, plugins: Plugins) -> None:
    """Raise an error if a plugin of a name could not register its part."""
    there = plugins.find(name)
    if there is not None:
        raise BtManipError(f"{there.label} is installed already; choose another name")
    plugins.parts.of(f"{kind}s").check(part)
    if kind == "behaviour":
        from bt_manip.bt import BehaviourRegistry

        if part in BehaviourRegistry().names():
            raise BtManipError(f"'{part}' is a node of the tree language already")


def _check_unused(name: str, names: dict[str, str], files: list[Path]) -> None:
    """Raise an error if the template's code uses the name otherwise."""
    if names["gear"] == "gear":
        return
    for path in files:
        clashes = names["gear"] == path.stem
        if path.suffix == ".py" and not clashes:
            used = _words(path)
            clashes = any(old in used and names[old] in used for old in ("Gear", "gear"))
        if clashes:
            raise BtManipError(
                f"'{name}' cannot be the name: the code of the package uses this word otherwise; "
                f"choose another, such as 'my-{name}'"
            )


def _words(path: Path) -> set[str]:
    """Return the names in a module, without attributes."""
    found, before = set(), ""
    with path.open("rb") as file:
        for token in tokenize.tokenize(file.readline):
            if token.type == tokenize.NAME and before != ".":
                found.add(token.string)
            before = token.string
    return found
