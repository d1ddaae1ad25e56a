"""Scenes by name, and scene files."""

import contextlib
from collections.abc import Callable
from pathlib import Path

from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.toml import read_fields, read_toml

from .scene import Scene
from .scene_keys import SceneError as SceneError
from .scene_keys import SceneFile


def is_scene_file(scene: str) -> bool:
    """Tell whether a text is the path of a scene file, not a registered name."""
    return scene.endswith(".toml") or "/" in scene or "\\" in scene


def find_scene(scene: str | Scene, parts: Parts) -> Scene:
    """Return a scene by its registered name or the path of its file; a scene itself stays.

    Raises:
        BtManipError: If there is no such scene, or its file is invalid.
    """
    if isinstance(scene, Scene):
        return scene
    if scene.partition(":")[0].endswith((".xml", ".py")):
        raise BtManipError(f"'{scene}' is a tree; a scene is a registered name or path.toml")
    return read_scene(scene, parts) if is_scene_file(scene) else parts.scenes.create(scene)


def seed_of(scene: str | Scene, parts: Parts) -> int:
    """Return the seed of a scene as of `find_scene`; 0 if it has none, or cannot be read."""
    if isinstance(scene, Scene):
        return scene.seed or 0
    if not is_scene_file(scene):
        return (parts.scenes.create(scene).seed or 0) if scene in parts.scenes else 0
    try:
        seed = read_toml(Path(scene)).get("seed", 0)
    except (OSError, ValueError):  # reported when the scene itself is read
        return 0
    return seed if isinstance(seed, int) and seed >= 0 else 0


def scene_of(path: Path) -> Callable[[], Scene]:
    """Return a factory to register for a scene file, which is read at each call."""

    def read() -> Scene:
        return read_scene(path)

    with contextlib.suppress(OSError, ValueError):
        read.__doc__ = str(read_toml(path).get("about", ""))
    return read


def read_scene(path: Path | str, parts: Parts | None = None) -> Scene:
    """Read a scene file.

    Args:
        path: The file; paths of models and robots in it are relative to its folder.
        parts: The registered parts; without them, names and parameters are not checked.

    Raises:
        SceneError: If it is invalid; the message lists all problems with file, line and key.
    """
    whole = SceneFile(Path(path), parts).whole
    given = read_fields(Scene, whole)
    try:
        return Scene(**given, source=str(path))
    except BtManipError as error:
        raise whole.error("robots", f"is wrong: {error}") from error
