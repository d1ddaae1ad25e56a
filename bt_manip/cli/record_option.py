"""The option ``--record``, read before a recorder or mujoco is imported."""

import re
from pathlib import Path

VIDEO = ("video", ".mp4", ".gif")
"""Name of the recorder of videos, and the suffixes of its files."""


def record_target(text: str) -> tuple[str, str, str]:
    """Return recorder, file and options of a value of ``--record``.

    The recorder is empty for a bare file, the file for a bare recorder.
    """
    found = re.fullmatch(r"(.*?)((?:\s+[a-z_]+=\S*)*)\s*", text)
    assert found is not None
    target, words = found.groups()
    name, equals, file = target.partition("=")
    return ("", target, words) if not equals and Path(target).suffix else (name, file, words)


def is_rendered(text: str) -> bool:
    """Return whether a value of ``--record`` asks for images of a camera."""
    name, file, options = record_target(text)
    cameras = any(word.startswith("cameras=") for word in options.split())
    return cameras or name in VIDEO or Path(file).suffix in VIDEO
