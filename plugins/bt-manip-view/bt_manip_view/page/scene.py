"""The scene of the page: visible geometry of a cell and poses of its bodies."""

import hashlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
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

AXES_LENGTH = 0.08
"""Length of body axes [m]."""

AXES_RADIUS = 0.003
"""Radius of body axes [m]."""

LARGEST_TEXTURE = (1024, 1024)
"""Size to which larger textures are reduced [pixels]."""

SMALLEST_MOTION = 1e-5
"""Smallest change of a pose that is sent, in position [m] and quaternion."""


class SceneView:
    """Shows a cell in viser: a node per entity, with a node per body and its geoms.

    Geometry is sent once per entity: `bind` adds and removes only nodes of changed entities, and
    `update` sends only changed poses.

    Args:
        server: The ``viser.ViserServer``.
    """

    def __init__(self, server: Any) -> None:
        self._server = server
        server.scene.configure_environment_map(environment_intensity=BRIGHTNESS)
        self._shown: dict[str, Any] = {}  # appearance of the entities, by name
        self._digests: dict[str, str] = {}  # of shapes, which may be equal in another cell
        self._nodes: dict[str, Any] = {}  # by entity
        self._meshes: dict[str, list[Any]] = {}  # by entity
        self._clickable: set[str] = set()  # entities
        self._added = Counter[str]()  # additions of each entity
        self._frames: dict[str, dict[str, Any]] = {}  # by entity and body
        self._bound: list[Any] = []  # nodes of the bodies
        self._sent = np.empty((0, 7))  # the poses sent last
        self._shapes: dict[str, Any] = {}  # by entity
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
                if self._shown.get(name) != appearance:
                    shapes = source.shapes(name)
                    digest = shapes_digest(shapes)
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
        """Send the changed poses."""
        self.show(self._source.poses())

    def on_click(self, entity: str, call: Callable[[], None]) -> None:
        """Call a function when an entity is clicked; call this again when it was added anew.

        Args:
            entity: Its name.
            call: The function, called by another thread.
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
        """The scene that is shown."""
        return self._source

    def show(self, poses: np.ndarray) -> None:
        """Send the poses that differ from those sent last.

        Args:
            poses: Poses of the frames of the source.  # (n, 7)
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
            # viser's page and player confuse poses of successive nodes with the same name.
            root += f" ({count})"
        self._nodes[name] = scene.add_frame(root, show_axes=False)
        frames, meshes = self._frames[name], self._meshes[name] = {}, []
        for body, shapes in bodies.items():
            # Poses are in the world: bodies are not children of each other.
            path = f"{root}/{body.replace('/', ':')}"
            frames[body] = scene.add_frame(
                path, show_axes=self._with_axes, axes_length=AXES_LENGTH, axes_radius=AXES_RADIUS
            )
            meshes += [self._add_shape(f"{path}/shape{i}", shape) for i, shape in enumerate(shapes)]

    def _add_shape(self, path: str, shape: VisualShape) -> Any:
        *rgb, alpha = shape.rgba
        if shape.kind == "box" and shape.size[2] < 1e-3 and min(shape.size[:2]) > GROUND_SIZE:
            alpha *= GROUND_OPACITY
        if shape.textured is not None:
            return self._server.scene.add_glb(
                path,
                _glb(shape.textured, alpha),
                position=shape.position,
                wxyz=shape.quat_wxyz,
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
