"""Meshes and materials shared by shapes."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from bt_manip.models.convex import convex_parts
from bt_manip.models.meshes import Mesh, read_mesh

SOLREF = "0.004 1"
"""Contact stiffness of the bundled models, without visible penetration at 50 N."""


class Assets:
    """The ``<asset>`` element of a model, and its files."""

    def __init__(self) -> None:
        self.element: Any = etree.Element("asset")
        self.files: dict[str, bytes] = {}
        self._meshes: dict[tuple[object, ...], Mesh] = {}
        self._names: dict[tuple[object, ...], list[str]] = {}
        self._materials: dict[tuple[object, ...], str] = {}
        self._images: dict[bytes, str] = {}

    def mesh(self, path: Path, submesh: str, centred: bool) -> Mesh:
        """Return a mesh; its file is read on first use.

        Raises:
            ModelError: If it cannot be read.
        """
        key = (path, submesh, centred)
        if key not in self._meshes:
            self._meshes[key] = read_mesh(path, submesh, centred)
        return self._meshes[key]

    def seen(self, key: tuple[object, ...], mesh: Mesh, stem: str) -> str:
        """Add a mesh for rendering; return its name."""
        # A mesh for rendering may have zero volume.
        return self._add(("seen", *key), [mesh], stem, "shell")[0]

    def colliding(self, key: tuple[object, ...], mesh: Mesh, stem: str, convex: str) -> list[str]:
        """Add a mesh for collision, as its hull or convex parts; return the names.

        The convex parts of a file count in either case.

        Raises:
            ModelError: If it cannot be decomposed.
        """
        known = ("collides", convex, *key)
        if known in self._names:
            return self._names[known]
        parts = convex_parts(mesh) if convex == "parts" else mesh.convex_parts or [mesh]
        return self._add(known, parts, stem, "convex")

    def material(
        self, rgba: np.ndarray, specular: float, emission: float, image: bytes | None = None
    ) -> str:
        """Add a material, optionally with an image; return its name."""
        key = (*(float(c) for c in rgba), specular, emission, self._texture(image))
        if key not in self._materials:
            name = f"material{len(self._materials)}"
            self._materials[key] = name
            attributes = {
                "name": name,
                "rgba": " ".join(f"{value:.9g}" for value in rgba),
                "specular": f"{specular:.9g}",
                "emission": f"{emission:.9g}",
            }
            if key[-1]:
                attributes["texture"] = str(key[-1])
            etree.SubElement(self.element, "material", attributes)
        return self._materials[key]

    def _texture(self, image: bytes | None) -> str:
        if image is None:
            return ""
        if image not in self._images:
            name = f"image{len(self._images)}"
            self._images[image] = name
            self.files[f"{name}.png"] = image
            attributes = {"name": name, "type": "2d", "file": f"{name}.png"}
            etree.SubElement(self.element, "texture", attributes)
        return self._images[image]

    def _add(
        self, key: tuple[object, ...], meshes: Sequence[Mesh], stem: str, inertia: str
    ) -> list[str]:
        if key not in self._names:
            names = []
            for mesh in meshes:
                plain = re.sub(r"[^A-Za-z0-9_-]+", "_", stem)
                name = f"{plain}_{len(self.files)}"
                self.files[f"{name}.obj"] = mesh.to_obj()
                attributes = {"name": name, "file": f"{name}.obj", "inertia": inertia}
                etree.SubElement(self.element, "mesh", attributes)
                names.append(name)
            self._names[key] = names
        return self._names[key]
