"""Mesh files, normalised to triangles in metres with z up."""

import contextlib
import io
import logging
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.exceptions import did_you_mean
from bt_manip.files import read_bytes
from bt_manip.models.errors import ModelError
from bt_manip.models.hardened_xml import parse_xml

MESHES = (".obj", ".stl", ".dae")
MAX_MESH_BYTES = 2**29  # 512 MiB
MAX_PARTS = 1_000  # groups of an .obj file that are parts of a solid; each takes milliseconds
MAX_LINE = 2**16  # characters of a line of OBJ: a polygon of some thousand corners

_CONVEX = 0.98  # least volume of a convex mesh, relative to its hull
_TURNS = {
    "X_UP": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    "Y_UP": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
}
"""Rotations from COLLADA's up axis to z."""


@dataclass(frozen=True)
class Mesh:
    """Triangles in metres, z up.

    Attributes:
        vertices: Corners [m].  # (n, 3)
        faces: Corners of each triangle.  # (m, 3)
        colour: Red, green, blue and opacity from 0 to 1, if the file has a single colour.
        watertight: Whether they enclose a volume.
        uv: Texture coordinates of the corners, from 0 to 1, if any.  # (n, 2)
        convex_parts: The groups of an OBJ file, where it has several and all are convex.
    """

    vertices: np.ndarray
    faces: np.ndarray
    colour: tuple[float, ...] | None = None
    watertight: bool = False
    uv: np.ndarray | None = None
    convex_parts: tuple["Mesh", ...] = ()

    def scaled(self, scale: np.ndarray) -> "Mesh":
        """Return the mesh scaled along its axes."""
        faces = self.faces[:, ::-1] if np.prod(scale) < 0 else self.faces
        parts = tuple(part.scaled(scale) for part in self.convex_parts)
        return replace(self, vertices=self.vertices * scale, faces=faces, convex_parts=parts)

    def to_obj(self) -> bytes:
        """Return the mesh as an OBJ file."""
        out = io.StringIO()
        for x, y, z in self.vertices.tolist():
            out.write(f"v {x:.9g} {y:.9g} {z:.9g}\n")
        corner = "{0}" if self.uv is None else "{0}/{0}"
        for u, v in [] if self.uv is None else self.uv.tolist():
            out.write(f"vt {u:.7g} {v:.7g}\n")
        for face in (self.faces + 1).tolist():
            out.write(f"f {' '.join(corner.format(i) for i in face)}\n")
        return out.getvalue().encode()


def read_mesh(path: Path, submesh: str = "", centred: bool = False) -> Mesh:
    """Read a mesh file; the parts of a scene are joined.

    Only the file itself is read, not the materials, images or other files to which it refers.

    Args:
        path: An .obj, .stl or .dae file.
        submesh: Name of the only part to read.
        centred: Whether to move the centre of this part to the origin.

    Raises:
        ModelError: If it cannot be read or holds no triangles.
    """
    import trimesh

    kind = path.suffix.lower()
    if kind not in MESHES:
        raise ModelError(f"{path}: a mesh is one of {', '.join(MESHES)}")
    try:
        data = read_bytes(path, MAX_MESH_BYTES)
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror}") from None
    if kind == ".obj" and max(map(len, data.split(b"\n"))) > MAX_LINE:
        raise ModelError(f"{path}: a line of more than {MAX_LINE} characters")
    turn = _collada_turn(data, path) if kind == ".dae" else np.eye(3)
    groups = len(re.findall(rb"^[og]\s", data, re.MULTILINE)) if kind == ".obj" else 0
    split: dict[str, Any] = {"split_objects": True, "split_groups": True} if groups > 1 else {}
    logging.getLogger("trimesh").setLevel(logging.ERROR)
    try:
        options = split if submesh else {}
        scene = trimesh.load_scene(io.BytesIO(data), file_type=kind[1:], **options)
        parts = _parts(scene, submesh, path, coloured=kind == ".dae")
        joined = _joined(parts)
        convex: tuple[Mesh, ...] = ()
        if 1 < groups <= MAX_PARTS and not submesh:
            solids = _parts(
                trimesh.load_scene(io.BytesIO(data), file_type="obj", **split), "", path
            )
            convex = tuple(solids) if len(solids) > 1 and all(map(_is_convex, solids)) else ()
        # Corners that differ only in texture coordinates are merged.
        whole = trimesh.Trimesh(joined.vertices, joined.faces, process=True)
        watertight = convex or whole.is_watertight
    except ModelError:
        raise
    except Exception as error:  # trimesh's readers have no documented exceptions
        raise ModelError(f"{path}: not a readable mesh: {error}") from None
    if whole.is_watertight and whole.volume < 0:  # inside out
        joined = replace(joined, faces=joined.faces[:, ::-1])
    vertices = joined.vertices @ turn.T
    if len(joined.faces) == 0 or not np.isfinite(vertices).all():
        raise ModelError(f"{path}: a mesh without triangles, or with non-finite points")
    if centred:
        vertices = vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return replace(joined, vertices=vertices, watertight=bool(watertight), convex_parts=convex)


def _is_convex(mesh: Mesh) -> bool:
    """Return whether a mesh encloses nearly the volume of its hull."""
    import trimesh

    solid = trimesh.Trimesh(mesh.vertices, mesh.faces, process=True)
    return bool(solid.is_watertight and solid.volume > _CONVEX * solid.convex_hull.volume)


def _parts(scene: Any, submesh: str, path: Path, coloured: bool = False) -> list[Mesh]:
    """Return the parts of a scene in its frame, in the file's units and axes."""
    parts = {}
    for node in scene.graph.nodes_geometry:
        T, name = scene.graph[node]
        part = scene.geometry[name]
        if hasattr(part, "faces"):
            vertices = np.asarray(part.vertices, dtype=np.float64) @ T[:3, :3].T + T[:3, 3]
            faces = np.asarray(part.faces)
            if np.linalg.det(T[:3, :3]) < 0:
                faces = faces[:, ::-1]
            uv = getattr(part.visual, "uv", None)
            uv = None if uv is None or len(uv) != len(vertices) else np.asarray(uv)[:, :2]
            material = getattr(part.visual, "material", None) if coloured else None
            colour = None if material is None else tuple(c / 255 for c in material.main_color)
            parts[node] = (name, Mesh(vertices, faces, colour, uv=uv))
    if submesh:
        chosen = [p for node, (name, p) in parts.items() if submesh in (node, name)]
        if not chosen:
            near = did_you_mean(submesh, {name for name, _ in parts.values()})
            raise ModelError(f"{path}: no part '{submesh}'{near}")
        return chosen
    if not parts:
        raise ModelError(f"{path}: a mesh without triangles")
    return [part for _, part in parts.values()]


def _joined(parts: list[Mesh]) -> Mesh:
    """Join parts; attributes that are not common to all parts are dropped."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=False)]
    uvs = [part.uv for part in parts if part.uv is not None]
    colours = {part.colour for part in parts}
    return Mesh(
        np.vstack([part.vertices for part in parts]),
        np.vstack(faces),
        colours.pop() if len(colours) == 1 else None,
        uv=np.vstack(uvs) if len(uvs) == len(parts) else None,
    )


def _collada_turn(data: bytes, path: Path) -> np.ndarray:
    """Return the rotation and scale to metres with z up, as a matrix."""  # (3, 3)
    root = parse_xml(data, path)
    asset = root.find("{*}asset")
    unit, up = 1.0, "Y_UP"
    if asset is not None:
        up = (asset.findtext("{*}up_axis") or up).strip()
        element = asset.find("{*}unit")
        if element is not None:
            with contextlib.suppress(ValueError):  # no number: metres
                unit = float(element.get("meter", ""))
    return unit * _TURNS.get(up, np.eye(3))
