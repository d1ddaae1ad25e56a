"""Images that lie on meshes."""

import struct
from pathlib import Path

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_MOST = 8192  # [pixels] each way
_MOST_BYTES = 64 * 2**20


def read_png(path: Path) -> bytes | None:
    """Read an image as MuJoCo takes it: PNG, of no more than 8192 pixels each way; else None."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            return None
        data = path.read_bytes()
    except OSError:
        return None
    if not data.startswith(_SIGNATURE) or len(data) < 24:
        return None
    width, height = struct.unpack(">II", data[16:24])
    return data if 0 < width <= _MOST and 0 < height <= _MOST else None


def image_of_obj(mesh: Path, root: Path | None) -> Path | None:
    """Find the image that the material file of an OBJ names (``map_Kd``).

    Args:
        mesh: The OBJ file.
        root: The folder that may not be left, if any.

    Returns:
        The image; None where there is none, or where different parts have different ones.
    """
    images = set()
    for name in _values(mesh, "mtllib"):
        for image in _values(_allowed(mesh.parent / name, root), "map_Kd"):
            plain = image.replace("\\", "/").split()[-1]
            # Gazebo keeps images in a folder of their own.
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
    """Return what stands behind a word at the beginning of lines."""
    if path is None:
        return []
    with path.open(encoding="utf-8", errors="replace") as lines:
        return [line[len(key) :].strip() for line in lines if line.startswith(f"{key} ")]
