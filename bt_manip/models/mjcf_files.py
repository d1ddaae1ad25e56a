"""Checks of an MJCF file and its referenced files, before MuJoCo and PyMJCF read them."""

from collections.abc import Iterator
from pathlib import Path

from lxml import etree

from bt_manip.files import check_regular, note_files
from bt_manip.models.errors import ModelError
from bt_manip.models.hardened_xml import check_numbers, read_xml
from bt_manip.models.meshes import MAX_MESH_BYTES

_FOLDERS = ("assetdir", "meshdir", "texturedir")
_MODELS = ("include", "model")
"""Elements that refer to MJCF files."""


def check_mjcf(path: Path) -> set[Path]:
    """Check an MJCF file and all files that it refers to.

    Missing files are reported by MuJoCo, not here.

    Returns:
        All meshes and images, if it attaches other models, else none.

    Raises:
        ModelError: If a file is not regular or too large, or if MJCF is not XML, includes itself,
            or has NaN or an impossible mass, density or moment of inertia.
    """
    root = read_xml(path)
    if root.tag != "mujoco":
        raise ModelError(f"{path}: expected <mujoco>, found <{root.tag}>")
    assets: set[Path] = set()
    _check(path, root, path.parent, [path.resolve()], set(), assets)
    note_files(f"files of {path.name}", assets)
    return assets if root.find("asset/model") is not None else set()


def _check(
    path: Path,
    root: etree._Element,
    main: Path,
    chain: list[Path],
    done: set[Path],
    assets: set[Path],
) -> None:
    folders = {main, path.parent}
    for compiler in root.iter("compiler"):
        folders |= {main / compiler.get(key, "") for key in _FOLDERS}
    for element in root.iter():
        where = f"{path}:{element.sourceline}: <{element.tag}>"
        check_numbers(path, element)
        for key, value in element.attrib.items():
            if str(key).startswith("file") and value:
                for found in _existing(folders, str(value), f"{where}: {key} '{value}'"):
                    if element.tag not in _MODELS:
                        assets.add(found)
                    else:
                        resolved = found.resolve()
                        if resolved in chain:
                            raise ModelError(f"{where}: {found.name} includes itself")
                        if resolved not in done:
                            base = found.parent if element.tag == "model" else main
                            _check(found, read_xml(found), base, [*chain, resolved], done, assets)
                            done.add(resolved)


def _existing(folders: set[Path], name: str, where: str) -> Iterator[Path]:
    """Yield the existing files of a name, after a check of their kind and size."""
    for path in sorted({folder / name for folder in folders}):
        if path.exists():
            try:
                check_regular(path, MAX_MESH_BYTES)
            except OSError as error:
                raise ModelError(f"{where} is {error.strerror}") from None
            yield path
