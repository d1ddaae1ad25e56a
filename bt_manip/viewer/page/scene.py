"""The scene of the page: the visible geometry of a cell, and the poses of its bodies."""

import hashlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from bt_manip.cell import SceneSource, TexturedMesh, Triangles, VisualShape

from .framing import Framing, rotated

BRIGHTNESS = 0.4
"""Intensity of the environment's light: with viser's 1, light colours of cells look white."""

SKY = ((214, 226, 240), (246, 248, 250))
"""Colours of the background at the top and at the bottom."""

AXES_LENGTH = 0.08
"""Length of the axes of a body [m]."""

AXES_RADIUS = 0.003
"""Their radius [m]."""

LARGEST_TEXTURE = (1024, 1024)
"""Size above which textures are sent smaller [pixels]."""

SMALLEST_MOTION = 1e-5
"""Smallest change of a pose that is sent, in position [m] and quaternion."""


class SceneView:
    """Shows a cell in viser: a node for each entity, in it one for each body with its geoms.

    Geometry is sent once for each entity. Entities that come and go add and remove only their own
    nodes, in `bind`; `update` sends the poses that have changed.
    """

    def __init__(self, server: Any) -> None:
        self._server = server
        server.scene.configure_environment_map(environment_intensity=BRIGHTNESS)
        sky = np.linspace(*SKY, 64).astype(np.uint8)
        server.scene.set_background_image(np.repeat(sky[:, None], 2, axis=1))
        self._shown: dict[str, Any] = {}  # the appearance of the entities, by name
        self._digests: dict[str, str] = {}  # of their shapes: those of another cell may be equal
        self._nodes: dict[str, Any] = {}  # by entity
        self._meshes: dict[str, list[Any]] = {}  # by entity
        self._clickable: set[str] = set()  # entities
        self._added = Counter[str]()  # how often each entity was added
        self._frames: dict[str, dict[str, Any]] = {}  # by entity and body
        self._bound: list[Any] = []  # nodes of the bodies
        self._sent = np.empty((0, 7))  # their poses as they were sent last
        self._shapes: dict[str, Any] = {}  # by entity
        self._framing = Framing(server)
        self._with_axes = False

    def bind(self, source: SceneSource) -> None:
        """Show the entities that the source has now, as they look now."""
        present = source.entities()
        changed = False
        with self._server.atomic():
            for name in [name for name in self._shown if name not in present]:
                self._remove(name)
            for name, appearance in present.items():
                if self._shown.get(name) != appearance:
                    shapes = source.shapes(name)
                    digest = _digest(shapes)
                    if self._digests.get(name) != digest:
                        self._remove(name)
                        self._add(name, shapes)
                        changed = True
                    self._shown[name], self._digests[name] = appearance, digest
                    self._shapes[name] = shapes
        self._source = source
        index = {name: i for i, name in enumerate(source.frames)}
        frames = {body: node for bodies in self._frames.values() for body, node in bodies.items()}
        sent = {id(node): pose for node, pose in zip(self._bound, self._sent, strict=True)}
        unknown = np.full(7, np.nan)
        self._sent = np.array([sent.get(id(node), unknown) for node in frames.values()]).reshape(
            -1, 7
        )
        self._bound = list(frames.values())
        self._ids = np.array([index[body] for body in frames], dtype=int)
        if changed:
            self._framing.show(source, self._shapes)
        self.update()

    def update(self) -> None:
        """Send the poses that have changed."""
        self.show(self._source.poses())

    def on_click(self, entity: str, call: Callable[[], None]) -> None:
        """Call a function when a present entity is clicked; once for each that is added.

        Args:
            entity: Its name.
            call: Called by another thread.
        """
        if entity not in self._clickable:
            self._clickable.add(entity)
            for mesh in self._meshes.get(entity, ()):
                mesh.on_click(lambda _: call())

    def show_frames(self, shown: bool) -> None:
        """Show or hide the axes of all bodies."""
        self._with_axes = shown
        for frames in list(self._frames.values()):
            for frame in list(frames.values()):
                frame.show_axes = shown

    @property
    def source(self) -> SceneSource:
        """What is shown."""
        return self._source

    def show(self, poses: np.ndarray) -> None:
        """Send the poses that differ from those that were sent last.

        Args:
            poses: Of the frames of the source.  # (n, 7)
        """
        self._framing.update(self._source)
        poses = poses[self._ids]
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
        if self._shown.pop(name, None) is not None:
            self._nodes.pop(name).remove()
            del self._frames[name], self._digests[name], self._shapes[name], self._meshes[name]
            self._clickable.discard(name)

    def _add(self, name: str, bodies: Mapping[str, Sequence[VisualShape]]) -> None:
        scene, root = self._server.scene, f"/{name}"
        self._added[name] += 1
        if (count := self._added[name]) > 1:
            # viser's page and player mix up the poses of two nodes that have the same name in turn.
            root += f" ({count})"
        self._nodes[name] = scene.add_frame(root, show_axes=False)
        frames, meshes = self._frames[name], self._meshes[name] = {}, []
        for body, shapes in bodies.items():
            # Poses are those in the world: bodies are no children of each other.
            path = f"{root}/{body.replace('/', ':')}"
            frames[body] = scene.add_frame(
                path, show_axes=self._with_axes, axes_length=AXES_LENGTH, axes_radius=AXES_RADIUS
            )
            meshes += [self._add_shape(f"{path}/shape{i}", shape) for i, shape in enumerate(shapes)]

    def _add_shape(self, path: str, shape: VisualShape) -> Any:
        if shape.textured is not None:
            return self._server.scene.add_glb(
                path,
                _glb(shape.textured, shape.rgba[3]),
                position=shape.position,
                wxyz=shape.quat_wxyz,
            )
        vertices, faces = triangles_of(shape)
        *rgb, alpha = shape.rgba
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
    """Return a mesh with its texture as a file of glTF."""
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


def _digest(bodies: Mapping[str, Sequence[VisualShape]]) -> str:
    """Return a digest of shapes; equal shapes have equal ones."""
    digest = hashlib.sha256()
    for body, shapes in bodies.items():
        for kind, *numbers, triangles, textured in shapes:
            digest.update(f"{body} {kind} ".encode())
            for part in (*numbers, *(triangles or ()), *(textured or ())):
                digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()
