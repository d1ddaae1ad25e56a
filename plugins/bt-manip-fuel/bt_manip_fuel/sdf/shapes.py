"""Conversion of SDF shapes to MJCF geoms."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.models import Assets, Mesh, ModelError, image_of_obj, read_png
from bt_manip_fuel.sdf.reader import Element, SdfReader
from bt_manip_fuel.sdf.uris import FetchFuel, find_file

_PLANE_HALF_THICKNESS = 5e-4  # [m]


class SdfShape(NamedTuple):
    """A geom without the pose of its parent.

    Attributes:
        attributes: Type and sizes, as in MJCF.
        T: Its pose in the frame of the visual or collision.
        rgba: Colour in the mesh's file.
        image: Texture image of the mesh's file.
        unfolded: Whether the mesh has texture coordinates.
    """

    attributes: dict[str, object]
    T: pin.SE3
    rgba: tuple[float, ...] | None = None
    image: bytes | None = None
    unfolded: bool = False


class ShapeReader:
    """Reads ``<geometry>``."""

    def __init__(self, reader: SdfReader, assets: Assets, fetch: FetchFuel, convex: str) -> None:
        self._reader = reader
        self._assets = assets
        self.fetch = fetch
        self._convex = convex

    def read(self, element: Element, *, collides: bool, static: bool) -> list[SdfShape]:
        """Return the geoms of a visual or collision; none for unsupported shapes.

        Raises:
            ModelError: If a size is missing or invalid, or a mesh cannot be read.
        """
        geometry = element.find("geometry")
        if geometry is None:
            raise self._reader.error(element, f"<{element.tag}> has no <geometry>")
        shape = next((child for child in geometry if child.tag != "empty"), None)
        if shape is None:
            return []
        match shape.tag:
            case "mesh":
                return self._mesh(shape, collides)
            case "plane":
                return self._plane(shape, static)
            case "cone":
                return self._cone(shape)
            case "box":
                size = self._lengths(shape, "size", (1, 1, 1)) / 2
            case "sphere":
                size = self._lengths(shape, "radius", (1,))
            case "ellipsoid":
                size = self._lengths(shape, "radii", (1, 1, 1))
            case "cylinder":
                size = self._radius_and_half(shape, 1.0, 1.0)
            case "capsule":  # in both formats, the length is that of the cylinder
                size = self._radius_and_half(shape, 0.5, 1.0)
            case _:
                self._reader.warn(shape, f"the shape <{shape.tag}> cannot be expressed; left out")
                return []
        return [SdfShape({"type": shape.tag, "size": size}, pin.SE3.Identity())]

    def _cone(self, shape: Element) -> list[SdfShape]:
        """Return a mesh of a cone, which MuJoCo lacks; its centre is at the origin."""
        radius, half = self._radius_and_half(shape, 0.5, 1.0)
        n = 48
        angles = np.arange(n) * 2 * np.pi / n
        rim = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(n, -half)])
        vertices = np.vstack([rim, [[0, 0, -half], [0, 0, half]]])
        i, j = np.arange(n), (np.arange(n) + 1) % n
        base = np.column_stack([j, i, np.full(n, n)])
        side = np.column_stack([i, j, np.full(n, n + 1)])
        mesh = Mesh(vertices, np.vstack([base, side]), watertight=True)
        name = self._assets.colliding(("cone", radius, half), mesh, "cone", "hull")[0]
        return [SdfShape({"type": "mesh", "mesh": name}, pin.SE3.Identity())]

    def _plane(self, shape: Element, static: bool) -> list[SdfShape]:
        normal = self._reader.vector(shape, "normal", (0, 0, 1))
        if np.linalg.norm(normal) < 1e-9:
            raise self._reader.error(shape, "a plane's normal of zeros")
        T = pin.SE3(
            pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), normal).matrix(), np.zeros(3)
        )
        half = self._lengths(shape, "size", (1, 1)) / 2
        if static:
            return [SdfShape({"type": "plane", "size": [*half, 1.0]}, T)]
        self._reader.warn(shape, "MuJoCo's planes do not move: it becomes a thin box")
        below = pin.SE3(np.eye(3), np.array([0.0, 0.0, -_PLANE_HALF_THICKNESS]))
        return [SdfShape({"type": "box", "size": [*half, _PLANE_HALF_THICKNESS]}, T * below)]

    def _mesh(self, shape: Element, collides: bool) -> list[SdfShape]:
        reader = self._reader
        reader.only(shape, {"uri", "scale", "submesh", "convex_decomposition"})
        uri, path = reader.text(shape, "uri"), None
        try:
            path, root = find_file(uri, reader.document(shape), self.fetch)
            submesh = reader.text(shape, "submesh/name")
            centred = reader.flag(shape, "submesh/center")
            mesh = self._assets.mesh(path, submesh, centred)
            scale = reader.vector(shape, "scale", (1, 1, 1))
            if not scale.all():
                raise reader.error(shape, "a mesh with a scale of 0")
            key = (path, submesh, centred, *scale.tolist())
            scaled = mesh.scaled(scale)
            if not collides:
                names = [self._assets.seen(key, scaled, path.stem)]
            else:
                parts = shape.get("optimization") == "convex_decomposition"
                convex = "parts" if parts else self._convex
                names = self._assets.colliding(key, scaled, path.stem, convex)
        except ModelError as error:
            reason = str(error).removeprefix(f"{reader.where(shape)}: ")
            if collides or path is None and reader.document(shape).root is not None:
                raise reader.error(shape, reason) from None
            reader.warn(shape, f"{reason}; the visual is left out")
            return []
        T = pin.SE3.Identity()
        image, unfolded = None, mesh.uv is not None
        if not collides and unfolded and path.suffix.lower() == ".obj":
            place = image_of_obj(path, root)
            image = None if place is None else read_png(place)
        return [
            SdfShape({"type": "mesh", "mesh": name}, T, mesh.colour, image, unfolded)
            for name in names
        ]

    def _radius_and_half(self, shape: Element, radius: float, length: float) -> np.ndarray:
        r = self._lengths(shape, "radius", (radius,))
        return np.concatenate([r, self._lengths(shape, "length", (length,)) / 2])

    def _lengths(self, shape: Element, tag: str, default: tuple[float, ...]) -> np.ndarray:
        values = self._reader.vector(shape, tag, default)
        if (values <= 0).any():
            raise self._reader.error(shape, f"<{tag}> of a <{shape.tag}> must be positive [m]")
        return values
