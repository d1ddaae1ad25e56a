"""A model as MJCF."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class MjcfModel:
    """A model as MJCF: a file, or text converted from another format.

    Attributes:
        address: Address of exactly this model.
        name: Name of the model.
        path: The file, if it is MJCF.
        xml: The text, if it was converted.
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
