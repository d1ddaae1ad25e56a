"""Model, tree and scene files in the package."""

from pathlib import Path

from bt_manip.exceptions import BtManipError, did_you_mean


def bundled_root(kind: str) -> Path:
    """Return the directory of bundled ``"models"``, ``"trees"`` or ``"scenes"``.

    A wheel has them in ``bt_manip/bundled/models``, ``bt_manip/bundled/trees`` and so on; a
    source checkout has them at the top level, beside the package.

    Raises:
        BtManipError: If they are missing in the installation.
    """
    package = Path(__file__).resolve().parent.parent
    places = (package / "bundled" / kind, package.parent / kind)
    for place in places:
        if place.is_dir():
            return place
    looked = " or ".join(str(place) for place in places)
    raise BtManipError(f"no bundled {kind}: looked for {looked}; is the installation complete?")


def bundled_path(name: str, kind: str = "models") -> Path:
    """Return the path of a bundled file.

    Args:
        name: Path inside the bundle, such as ``"panda/panda.xml"``.
        kind: ``"models"`` or ``"trees"``.

    Raises:
        BtManipError: If there is no such file, with suggestions.
    """
    root = bundled_root(kind)
    path = root / name
    if not path.is_file():
        valid = (p.relative_to(root).as_posix() for p in root.rglob("*.xml"))
        raise BtManipError(f"no bundled file '{name}' in {root}{did_you_mean(name, valid)}")
    return path
