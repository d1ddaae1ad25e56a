"""Formats of model files: recognition, and conversion to MJCF."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from bt_manip.models.changed_mjcf import repaired_mjcf
from bt_manip.models.downloads import Progress
from bt_manip.models.found_model import FoundModel, MjcfModel
from bt_manip.models.hardened_xml import read_xml
from bt_manip.models.lone_mesh import convert_mesh
from bt_manip.models.urdf import convert_urdf


@dataclass(frozen=True)
class ModelFormat:
    """Format of model files.

    Attributes:
        convert: ``convert(found, convex=..., progress=...)`` returns a `FoundModel` as MJCF, with
            the convex ``"hull"`` or convex ``"parts"`` of meshes for collision; `progress` gets
            the progress of a download.
        suffixes: Suffixes of the files, in lower case: ``(".urdf",)``.
        tag: Root element of files that end in ``.xml``; empty for none.
        find_in: Returns the model file in a folder, or None.
    """

    convert: Callable[..., MjcfModel]
    suffixes: tuple[str, ...] = ()
    tag: str = ""
    find_in: Callable[[Path], Path | None] | None = None

    def find(self, path: Path, tag: str) -> Path | None:
        """Return the file of a path, which may be a folder, or None if it has another format.

        Args:
            path: An existing file or folder.
            tag: Root element of a file that ends in ``.xml``, else empty.
        """
        if path.is_dir():
            return None if self.find_in is None else self.find_in(path)
        known = tag == self.tag if tag else path.suffix.lower() in self.suffixes
        return path if known else None


def built_in_formats() -> dict[str, ModelFormat]:
    """Return the built-in formats, by name."""
    return {
        "mjcf": ModelFormat(_mjcf, tag="mujoco"),
        "urdf": ModelFormat(convert_urdf, suffixes=(".urdf", ".xacro"), tag="robot"),
        "mesh": ModelFormat(convert_mesh, suffixes=(".obj", ".stl", ".dae")),
    }


def recognise(path: Path, formats: Mapping[str, ModelFormat]) -> tuple[str, Path] | None:
    """Return the format and the file of a path, or None if no format fits."""
    tag = root_tag(path)
    for name, model_format in formats.items():
        if (file := model_format.find(path, tag)) is not None:
            return name, file
    return None


def root_tag(path: Path) -> str:
    """Return the root element of a file that ends in ``.xml``; an empty text for others."""
    if path.suffix.lower() != ".xml" or path.is_dir():
        return ""
    return str(read_xml(path).tag)


def _mjcf(found: FoundModel, *, convex: str, progress: Progress) -> MjcfModel:
    xml, warnings = repaired_mjcf(found.path)
    return MjcfModel(found.address, found.name, found.path, xml, warnings=warnings)
