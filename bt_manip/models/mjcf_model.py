"""A model in the form that MuJoCo and PyMJCF load."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class MjcfModel:
    """A model as MJCF: a file as it is, or text that was made of another format.

    Attributes:
        address: An address that finds exactly this model again.
        name: What to call it.
        path: The file, when it is MJCF itself.
        xml: The text, when it was made.
        assets: What the text names as files.
        static: Whether the model says that it does not move; None when it says nothing.
        warnings: What could not be said in MJCF, each with file and line.
    """

    address: str
    name: str
    path: Path | None = None
    xml: str = ""
    assets: Mapping[str, bytes] = field(default_factory=dict)
    static: bool | None = None
    warnings: tuple[str, ...] = ()
