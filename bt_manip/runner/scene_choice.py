"""Finding scenes by name or file."""

import contextlib
import tomllib
from collections.abc import Callable
from pathlib import Path

from bt_manip.registry import Parts
from bt_manip.runner.scene import Scene
from bt_manip.runner.scene_file import read_scene


def is_scene_file(scene: str) -> bool:
    """Tell whether a text is the path of a scene file, not a registered name."""
    return scene.endswith(".toml") or "/" in scene or "\\" in scene


def find_scene(scene: str, parts: Parts) -> Scene:
    """Return the scene of a name or file.

    Args:
        scene: A registered name, or the path of a TOML file.
        parts: The registered parts.

    Raises:
        BtManipError: If there is no such scene, or its file is wrong.
    """
    return read_scene(scene, parts) if is_scene_file(scene) else parts.scenes.create(scene)


def seed_of(scene: str, parts: Parts) -> int:
    """Return the seed of a scene; 0 if it has none, or cannot be read.

    Args:
        scene: A registered name, or the path of a TOML file.
        parts: The registered parts.
    """
    if not is_scene_file(scene):
        return (parts.scenes.create(scene).seed or 0) if scene in parts.scenes else 0
    try:
        seed = tomllib.loads(Path(scene).read_text("utf-8")).get("seed", 0)
    except (OSError, ValueError):  # reported when the scene itself is read
        return 0
    return seed if isinstance(seed, int) and seed >= 0 else 0


def scene_of(path: Path) -> Callable[[], Scene]:
    """Return a factory of a file's scene, to register it; the file is read when it is called."""

    def read() -> Scene:
        return read_scene(path)

    with contextlib.suppress(OSError, ValueError):
        read.__doc__ = str(tomllib.loads(path.read_text("utf-8")).get("about", ""))
    return read
