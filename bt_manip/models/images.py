"""Texture images of meshes."""

import struct
from pathlib import Path

from bt_manip.files import read_bytes

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_MAX_SIZE = 8192  # [pixels] width and height


def read_png(path: Path) -> bytes | None:
    """Return a PNG file of at most 8192 x 8192 pixels, as MuJoCo supports it, or None."""
    try:
        data = read_bytes(path)
    except OSError:
        return None
    if not data.startswith(_SIGNATURE) or len(data) < 24:
        return None
    width, height = struct.unpack(">II", data[16:24])
    return data if 0 < width <= _MAX_SIZE and 0 < height <= _MAX_SIZE else None


def image_of_obj(mesh: Path, root: Path | None) -> Path | None:
    """Return the image in the material file of an OBJ (``map_Kd``).

    Args:
        mesh: The OBJ file.
        root: Folder outside which no file is read, if any.

    Returns:
        The image; None without one, or if parts have different images.
    """
    images = set()
    for name in _values(mesh, "mtllib"):
        for image in _values(_allowed(mesh.parent / name, root), "map_Kd"):
            plain = image.replace("\\", "/").split()[-1]
            # Gazebo has a separate folder for images.
            gazebo = mesh.parent.parent / "materials" / "textures" / Path(plain).name
            for place in (mesh.parent / plain, gazebo):
                if (found := _allowed(place, root)) is not None:
                    images.add(found)
                    break
    return images.pop() if len(images) == 1 else None


def _allowed(path: Path, root: Path | None) -> Path | None:
    if root is not None and not path.resolve().is_relative_to(root.resolve()):
        return None
    return path if path.is_file() else None


def _values(path: Path | None, key: str) -> list[str]:
    """Return the values of all lines with a key."""
    if path is None:
        return []
    with path.open(encoding="utf-8", errors="replace") as lines:
        return [line[len(key) :].strip() for line in lines if line.startswith(f"{key} ")]
