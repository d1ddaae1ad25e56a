"""Reading of SDF documents: values with defaults, and lines of elements."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.models import ModelError, read_xml

Element = Any
"""An element of lxml, which has no type stubs."""


def is_true(text: str | None) -> bool:
    """Return whether a text says true; false where it is missing."""
    return (text or "").lower() in ("true", "1")


class SdfDocument(NamedTuple):
    """A document, and the folder outside which it may not refer to files."""

    path: Path
    root: Path | None


class SdfReader:
    """Reads documents and values, and collects warnings with file and line."""

    def __init__(self) -> None:
        self.warnings: list[str] = []
        self._documents: dict[Element, SdfDocument] = {}

    def open_model(self, path: Path, root: Path | None) -> Element:
        """Read a document and return its model.

        Raises:
            ModelError: If it cannot be read, or has no model.
        """
        document = read_xml(path)
        self._documents[document] = SdfDocument(path, root)
        if document.tag != "sdf":
            raise self.error(document, f"expected <sdf>, found <{document.tag}>")
        models = document.findall("model")
        if not models:
            what = "it is a world; give one of its models" if document.find("world") is not None \
                else "it has no <model>"  # fmt: skip
            raise self.error(document, what)
        for other in models[1:]:
            self.warn(other, f"a second model '{other.get('name')}' in the file is left out")
        return models[0]

    def document(self, element: Element) -> SdfDocument:
        """Return the document of an element."""
        return self._documents[element.getroottree().getroot()]

    def where(self, element: Element) -> str:
        """Return ``file:line`` of an element."""
        return f"{self.document(element).path}:{element.sourceline}"

    def warn(self, element: Element, text: str) -> None:
        """Add a warning about an unsupported element."""
        warning = f"{self.where(element)}: {text}"
        if warning not in self.warnings:
            self.warnings.append(warning)

    def error(self, element: Element, text: str) -> ModelError:
        """Return an error with file and line."""
        return ModelError(f"{self.where(element)}: {text}")

    def only(self, element: Element, known: Iterable[str]) -> None:
        """Warn about unsupported children."""
        for child in element:
            if child.tag not in known:
                self.warn(child, f"<{child.tag}> of <{element.tag}> cannot be expressed")

    def text(self, element: Element, tag: str) -> str:
        """Return the text of a child, or of a path of children."""
        return (element.findtext(tag) or "").strip()

    def flag(self, element: Element, tag: str, default: bool = False) -> bool:
        """Return the boolean value of a child.

        Raises:
            ModelError: If it is not a boolean.
        """
        value = self.text(element, tag).lower()
        if value in ("", "true", "1", "false", "0"):
            return is_true(value) if value else default
        raise self.error(element.find(tag), f"<{tag}>: expected true or false, got '{value}'")

    def number(self, element: Element, tag: str, default: float) -> float:
        """Return the number in a child, which may be infinite.

        Raises:
            ModelError: If it is none.
        """
        child = element.find(tag)
        if child is None or not (child.text or "").strip():
            return default
        return float(self.numbers(child, 1, finite=False).item())

    def vector(self, element: Element, tag: str, default: Iterable[float]) -> np.ndarray:
        """Return the finite numbers in a child, with the length of the default.

        Raises:
            ModelError: If their number is another, or one of them is not finite.
        """
        child, values = element.find(tag), np.array(list(default), dtype=float)
        if child is None or not (child.text or "").strip():
            return values
        return self.numbers(child, len(values))

    def numbers(self, element: Element, count: int, finite: bool = True) -> np.ndarray:
        """Return the numbers in an element.

        Raises:
            ModelError: If their count is another, or they are not numbers.
        """
        words = (element.text or "").split()
        try:
            values = np.array([float(word) for word in words])
        except ValueError:
            values = np.array([np.nan])
        good = np.isfinite(values).all() if finite else not np.isnan(values).any()
        if len(words) != count or not good:
            raise self.error(
                element, f"<{element.tag}>: expected {count} numbers, got '{' '.join(words)}'"
            )
        return values

    def pose(self, element: Element | None) -> pin.SE3:
        """Return a ``<pose>``: position and roll, pitch, yaw about fixed axes, or a quaternion.

        Raises:
            ModelError: If it is none.
        """
        if element is None or not (element.text or "").strip():
            return pin.SE3.Identity()
        form = element.get("rotation_format", "euler_rpy")
        if form == "quat_xyzw":
            values = self.numbers(element, 7)
            norm = float(np.linalg.norm(values[3:]))
            if norm < 1e-9:
                raise self.error(element, "<pose>: a quaternion of zeros")
            return pin.SE3(pin.Quaternion(values[3:] / norm).matrix(), values[:3])
        values = self.numbers(element, 6)
        if is_true(element.get("degrees")):
            values[3:] = np.radians(values[3:])
        # Roll, pitch, yaw about fixed axes: Rz(yaw) Ry(pitch) Rx(roll), as in Pinocchio.
        return pin.SE3(pin.rpy.rpyToMatrix(values[3:]), values[:3])
