"""The local file of a model."""

import re
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class FoundModel:
    """Local file of a model.

    Attributes:
        address: Address of exactly this model, with its version or absolute path.
        name: Name of the model.
        path: The file.
        format: Name of its format: ``"mjcf"``, ``"urdf"``, ``"mesh"``, or one of a plugin.
        root: Folder outside which a downloaded model may not refer to files; None for the user's
            own files.
    """

    address: str
    name: str
    path: Path
    format: str
    root: Path | None = None


def model_name(text: str) -> str:
    """Return a text as a name that is valid in a cell, MuJoCo and a tree."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", text).strip("_") or "model"
