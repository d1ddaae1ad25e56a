"""Mesh files, as the one form that MuJoCo reads without questions."""

import io
import logging
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.exceptions import did_you_mean
from bt_manip.models.errors import ModelError
from bt_manip.models.hardened_xml import parse_xml

if TYPE_CHECKING:
    from trimesh import Trimesh

MESHES = (".obj", ".stl", ".dae")

_TURNS = {
    "X_UP": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "Y_UP": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
}
"""From COLLADA's upward axis to z."""


@dataclass(frozen=True)
class Mesh:
    """Triangles in metres, z up.

    Attributes:
        vertices: Corners [m].  # (n, 3)
        faces: Corners of each triangle.  # (m, 3)
        colour: Red, green, blue and opacity from 0 to 1, where the file has one for all of it.
        watertight: Whether they enclose a volume.
    """

    vertices: np.ndarray
    faces: np.ndarray
    colour: tuple[float, ...] | None = None
    watertight: bool = False

    def scaled(self, scale: np.ndarray) -> "Mesh":
        """Stretch it along its axes."""
        faces = self.faces[:, ::-1] if np.prod(scale) < 0 else self.faces
        return Mesh(self.vertices * scale, faces, self.colour, self.watertight)

    def to_obj(self) -> bytes:
        """Write it as an OBJ file."""
        out = io.StringIO()
        for x, y, z in self.vertices.tolist():
            out.write(f"v {x:.9g} {y:.9g} {z:.9g}\n")
        for a, b, c in (self.faces + 1).tolist():
            out.write(f"f {a} {b} {c}\n")
        return out.getvalue().encode()


def read_mesh(path: Path, submesh: str = "", centred: bool = False) -> Mesh:
    """Read a mesh file; parts of a scene become one mesh.

    Nothing but the file itself is read: no materials, images or other files that it names.

    Args:
        path: An .obj, .stl or .dae file.
        submesh: Take only the part of this name.
        centred: Move that part's middle to the origin.

    Raises:
        ModelError: When it cannot be read or holds no triangles.
    """
    import trimesh

    kind = path.suffix.lower()
    if kind not in MESHES:
        raise ModelError(f"{path}: a mesh is one of {', '.join(MESHES)}")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror}") from None
    turn = _collada_turn(data, path) if kind == ".dae" else np.eye(3)
    options: dict[str, Any] = {"split_object": True, "skip_materials": True} if submesh else {}
    logging.getLogger("trimesh").setLevel(logging.ERROR)
    try:
        scene = trimesh.load_scene(
            io.BytesIO(data), file_type=kind[1:], **(options if kind == ".obj" else {})
        )
        parts = _parts(scene, submesh, path)
        mesh: Any = trimesh.util.concatenate(parts) if len(parts) > 1 else parts[0]
    except ModelError:
        raise
    except Exception as error:  # readers of foreign files raise anything
        raise ModelError(f"{path}: not a mesh that can be read: {error}") from None
    vertices = np.asarray(mesh.vertices, dtype=np.float64) @ turn.T
    if len(mesh.faces) == 0 or not np.isfinite(vertices).all():
        raise ModelError(f"{path}: a mesh without triangles, or with points that are no numbers")
    if centred:
        vertices = vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return Mesh(vertices, np.asarray(mesh.faces), _colour(parts), bool(mesh.is_watertight))


def _parts(scene: Any, submesh: str, path: Path) -> list["Trimesh"]:
    """List the parts of a scene where they belong."""
    parts = {}
    for node in scene.graph.nodes_geometry:
        T, name = scene.graph[node]
        part = scene.geometry[name]
        if hasattr(part, "faces"):
            parts[node] = (name, part.copy().apply_transform(T))
    if submesh:
        chosen = [p for node, (name, p) in parts.items() if submesh in (node, name)]
        if not chosen:
            near = did_you_mean(submesh, {name for name, _ in parts.values()})
            raise ModelError(f"{path}: no part '{submesh}'{near}")
        return chosen
    if not parts:
        raise ModelError(f"{path}: a mesh without triangles")
    return [part for _, part in parts.values()]


def _collada_turn(data: bytes, path: Path) -> np.ndarray:
    """Give the turn and scale into metres with z up."""  # (3, 3)
    root = parse_xml(data, path)
    asset = root.find("{*}asset")
    unit, up = 1.0, "Y_UP"
    if asset is not None:
        up = (asset.findtext("{*}up_axis") or up).strip()
        element = asset.find("{*}unit")
        if element is not None and re.fullmatch(r"[0-9.eE+-]+", element.get("meter", "")):
            unit = float(element.get("meter", "1"))
    return unit * _TURNS.get(up, np.eye(3))


def _colour(parts: list["Trimesh"]) -> tuple[float, ...] | None:
    """Give the one colour of all parts, if there is one."""
    colours = set()
    for part in parts:
        material = getattr(part.visual, "material", None)
        if material is None:
            return None
        colours.add(tuple(int(c) for c in material.main_color))
    return tuple(c / 255.0 for c in colours.pop()) if len(colours) == 1 else None
