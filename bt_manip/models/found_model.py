"""The local file of a model, and the model as MJCF."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
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


@dataclass(frozen=True)
class MjcfModel:
    """A model as MJCF: a file, or text converted from another format.

    Attributes:
        address: Address of exactly this model.
        name: Name of the model.
        path: The file, if it is MJCF.
        xml: The text, if it was converted, or differs from the file.
        assets: Files that the text refers to, by name.
        static: Whether the model declares that it is fixed; None if it declares nothing.
        warnings: Elements that MJCF cannot express, with file and line.
    """

    address: str
    name: str
    path: Path | None = None
    xml: str = ""
    assets: Mapping[str, bytes] = field(default_factory=dict)
    static: bool | None = None
    warnings: tuple[str, ...] = ()
