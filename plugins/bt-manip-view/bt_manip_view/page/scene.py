"""The scene of the page: visible geometry of a cell and poses of its bodies."""

import hashlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from bt_manip_recording import SceneSource, TexturedMesh, Triangles, VisualShape

from .framing import Framing, rotated

BRIGHTNESS = 0.4
"""Intensity of the environment light; at viser's default, 1, light colours look white."""

GROUND_SIZE, GROUND_OPACITY = 4.0, 0.35
"""Smallest width of a plane that is a ground [m], and its opacity.

The sky shows through it: it is light or dark like the page of each browser.
"""

AXES = {"axes_length": 0.08, "axes_radius": 0.003}
"""Length and radius of body axes [m]."""

LARGEST_TEXTURE = (1024, 1024)
"""Size to which larger textures are reduced [pixels]."""

SMALLEST_MOTION = 1e-5
"""Smallest change of a pose that is sent, in position [m] and quaternion."""


@dataclass
class _Shown:
    """An entity in the scene."""

    appearance: Any
    shapes: Mapping[str, Sequence[VisualShape]]
    digest: str  # of its shapes, which may be equal in another cell
    node: Any
    frames: dict[str, Any]  # by body
    meshes: list[Any]
    clickable: bool = False


class SceneView:
    """Shows a cell in viser: a node per entity, with a node per body and its geoms.

    Geometry is sent once per entity: `bind` adds and removes only nodes of changed entities, and
    `update` sends only changed poses.
    """

    def __init__(self, server: Any) -> None:
        self._server = server
        server.scene.configure_environment_map(environment_intensity=BRIGHTNESS)
        self._shown: dict[str, _Shown] = {}  # by name
        self._added = Counter[str]()  # additions of each entity
        self._bound: list[Any] = []  # nodes of the bodies
        self._sent = np.empty((0, 7))  # the poses sent last
        self._framing = Framing(server)
        self._with_axes = False

    def bind(self, source: SceneSource) -> None:
        """Show the present entities of a source."""
        present = source.entities()
        changed = False
        with self._server.atomic():
            for name in [name for name in self._shown if name not in present]:
                self._remove(name)
            for name, appearance in present.items():
                before = self._shown.get(name)
                if before is not None and before.appearance == appearance:
                    continue
                shapes = source.shapes(name)
                digest = shapes_digest(shapes)
                if before is None or before.digest != digest:
                    self._remove(name)
                    self._shown[name] = self._add(name, appearance, shapes, digest)
                    changed = True
                else:
                    before.appearance = appearance
        self._source = source
        index = {name: i for i, name in enumerate(source.frames)}
        frames = {body: node for one in self._shown.values() for body, node in one.frames.items()}
        sent = {id(node): pose for node, pose in zip(self._bound, self._sent, strict=True)}
        unknown = np.full(7, np.nan)
        self._sent = np.array([sent.get(id(node), unknown) for node in frames.values()]).reshape(
            -1, 7
        )
        self._bound = list(frames.values())
        self._ids = np.array([index[body] for body in frames], dtype=int)
        if changed:
            self._framing.show(source, {name: one.shapes for name, one in self._shown.items()})
        self.update()

    def on_click(self, entity: str, call: Callable[[], None]) -> None:
        """Call a function, from another thread, at clicks on an entity until it is added anew."""
        shown = self._shown.get(entity)
        if shown is not None and not shown.clickable:
            shown.clickable = True
            for mesh in shown.meshes:
                mesh.on_click(lambda _: call())

    def show_frames(self, shown: bool) -> None:
        """Show or hide the axes of all bodies."""
        self._with_axes = shown
        for one in list(self._shown.values()):
            for frame in one.frames.values():
                frame.show_axes = shown

    def update(self) -> None:
        """Send the poses that differ from those sent last."""
        self._framing.update(self._source)
        poses = self._source.poses()[self._ids]
        still = np.all(np.abs(poses - self._sent) < SMALLEST_MOTION, axis=1)  # NaN: not sent yet
        moved = np.flatnonzero(~still).tolist()
        if not moved:
            return
        with self._server.atomic():
            for i in moved:
                node = self._bound[i]
                node.position, node.wxyz = poses[i, :3], poses[i, 3:]
        self._sent[moved] = poses[moved]

    # Internal

    def _remove(self, name: str) -> None:
        if name in self._shown:
            self._shown.pop(name).node.remove()

    def _add(
        self, name: str, appearance: Any, shapes: Mapping[str, Sequence[VisualShape]], digest: str
    ) -> _Shown:
        scene, root = self._server.scene, f"/{name}"
        self._added[name] += 1
        if (count := self._added[name]) > 1:
            # viser's page and player confuse poses of successive nodes with the same name.
            root += f" ({count})"
        added = _Shown(appearance, shapes, digest, scene.add_frame(root, show_axes=False), {}, [])
        for body, of_body in shapes.items():
            # Poses are in the world: bodies are not children of each other.
            path = f"{root}/{body.replace('/', ':')}"
            added.frames[body] = scene.add_frame(path, show_axes=self._with_axes, **AXES)
            added.meshes += [self._add_shape(f"{path}/shape{i}", s) for i, s in enumerate(of_body)]
        return added

    def _add_shape(self, path: str, shape: VisualShape) -> Any:
        *rgb, alpha = shape.rgba
        if shape.kind == "box" and shape.size[2] < 1e-3 and min(shape.size[:2]) > GROUND_SIZE:
            alpha *= GROUND_OPACITY
        if shape.textured is not None:
            data = _glb(shape.textured, alpha)
            return self._server.scene.add_glb(
                path, data, position=shape.position, wxyz=shape.quat_wxyz
            )
        vertices, faces = triangles_of(shape)
        return self._server.scene.add_mesh_simple(
            path,
            rotated(shape.quat_wxyz, vertices) + shape.position,
            faces,
            color=tuple(round(255 * part) for part in rgb),
            opacity=None if alpha >= 1.0 else alpha,
            flat_shading=shape.kind in ("box", "cylinder"),
        )


def triangles_of(shape: VisualShape) -> Triangles:
    """Return the triangles of a shape, in its frame."""
    if shape.triangles is not None:
        return shape.triangles
    x, y, z = shape.size
    make = trimesh.creation
    if shape.kind == "box":
        mesh = make.box((x, y, z))
    elif shape.kind == "cylinder":
        mesh = make.cylinder(x / 2, z, sections=48)
    else:
        mesh = make.icosphere(3, 0.5)
        mesh.apply_scale((x, y, z))
    return Triangles(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def _glb(textured: TexturedMesh, alpha: float) -> bytes:
    """Return a textured mesh as binary glTF."""
    vertices, normals, coordinates, faces, pixels = textured
    image = Image.fromarray(pixels)
    image.thumbnail(LARGEST_TEXTURE)
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=image,
        baseColorFactor=(1.0, 1.0, 1.0, alpha),
        alphaMode="OPAQUE" if alpha >= 1.0 else "BLEND",
        metallicFactor=0.0,
        roughnessFactor=1.0,
    )
    upwards = coordinates * (1.0, -1.0) + (0.0, 1.0)  # trimesh has v = 0 at the bottom
    visual = trimesh.visual.TextureVisuals(uv=upwards, material=material)
    mesh = trimesh.Trimesh(vertices, faces, vertex_normals=normals, visual=visual, process=False)
    data = mesh.export(file_type="glb", include_normals=True)
    assert isinstance(data, bytes)
    return data


def shapes_digest(bodies: Mapping[str, Sequence[VisualShape]]) -> str:
    """Return a digest of shapes; equal shapes have equal digests."""
    digest = hashlib.sha256()
    for body, shapes in bodies.items():
        for kind, *numbers, triangles, textured in shapes:
            digest.update(f"{body} {kind} ".encode())
            for part in (*numbers, *(triangles or ()), *(textured or ())):
                digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()
