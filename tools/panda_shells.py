"""Write the rounded shells of `models/panda/panda.xml` as inline meshes.

A shell is a row of rings. Each ring spans two points of the link's silhouette, seen at right
angles to its plane of symmetry, and has a depth: short tables in millimetres, in the proportions of
the real arm. Where a shell meets its neighbour at a joint it stays open. The whole model travels as
text through PyMJCF whenever a cell is compiled: hence few vertices, and triangles only where a
shell is not convex. Run it after changing a table:

    python tools/panda_shells.py
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

PANDA = Path(__file__).parents[1] / "models" / "panda" / "panda.xml"
BLOCK = re.compile(r"( *<!-- Shells.*?-->\n *<asset>\n)(.*?)( *</asset>\n)", re.DOTALL)


class Loft(NamedTuple):
    """Describe a shell by rings from one end to the other [mm].

    A ring is (u0, v0, u1, v1, depth): its first and last silhouette point in the plane of symmetry
    and its half width at right angles to it. Exponent 2 makes an ellipse, larger ones a rounded
    rectangle.
    """

    axes: str  # which link axes are u, v and the depth
    rings: tuple[tuple[float, ...], ...]
    exponent: float = 2.0
    closed: tuple[bool, bool] = (False, False)  # whether the first and the last ring get a lid
    segments: int = 16
    convex: bool = False  # then MuJoCo finds the triangles, lids included, and the file needs none


class Hull(NamedTuple):
    """Describe a convex shell by circles (x, y, z, radius, normal axis) that it wraps [mm]."""

    circles: tuple[tuple[float, float, float, float, str], ...]
    segments: int = 14


SHELLS: dict[str, Loft | Hull] = {
    # link0: from the foot to the round neck.
    "base": Loft(
        "xzy",
        (
            (-133, 0, 72, 0, 75),
            (-131, 25, 67, 25, 74),
            (-126, 50, 63, 50, 73),
            (-111, 73, 59, 73, 69.5),
            (-92, 89, 57.5, 89, 64.5),
            (-77, 101, 57, 101, 60),
            (-63, 114, 56, 114, 56.5),
            (-57, 126, 55, 126, 55.2),
            (-55, 141, 55, 141, 55),
        ),
        exponent=2.7,
    ),
    "foot": Hull(
        (
            (-138, 40, 0, 14, "z"),
            (-138, -40, 0, 14, "z"),
            (0, 78, 0, 15, "z"),
            (0, -78, 0, 15, "z"),
            (-138, 40, 9, 13, "z"),
            (-138, -40, 9, 13, "z"),
            (0, 78, 9, 14, "z"),
            (0, -78, 9, 14, "z"),
        ),
        segments=10,
    ),
    # link1, and link2 turned by -90 deg about x: from the tube round a bend to half of a joint.
    # The last ring lies inside the other half, so that no light falls through the seam.
    "shoulder": Loft(
        "yzx",
        (
            (-55, -192, 55, -192, 55),
            (-59, -118, 53, -121, 54.5),
            (-68, -92, 40, -102, 54),
            (-86, -66, 14, -87, 53),
            (-112, -39, -7, -70, 51),
            (-126, -14, -11, -61, 50.5),
            (-129, 6, -11, -57, 50.5),
            (-122, 31, -10, -56, 51.5),
            (-104, 48, -8, -55, 53.5),
            (-62, 54, -5, -55, 55),
            (0, 55, 0, -55, 55),
            (4, 52, 4, -52, 52),
        ),
        segments=20,
    ),
    # link3, and link4 turned by 90 deg about x. It ends inside the next tube: lids cast shadows.
    "bell": Loft(
        "xzy",
        (
            (-52, -128, 52, -128, 52),
            (-54.8, -122, 54.8, -122, 54.8),
            (-54, -90, 54, -90, 54),
            (-50, -58, 50, -58, 50),
            (-43, -35, 43, -35, 43),
            (-33, -22, 33, -22, 33),
            (-17, -14, 17, -14, 17),
        ),
        convex=True,
    ),
    "web": Hull(
        (
            (70, -17, -15, 29, "y"),
            (70, 47, -15, 29, "y"),
            (70, -10, -15, 33, "y"),
            (70, 40, -15, 33, "y"),
            (12, 0, -42, 33, "z"),
            (12, 0, -85, 41, "z"),
        ),
    ),
    # link5: the forearm, from the bell over the slender part to the joint.
    "forearm": Loft(
        "yzx",
        (
            (-55, -261, 55, -261, 55),
            (-52.5, -229, 58, -231, 53),
            (-40, -198, 69, -205, 47.5),
            (-12, -177, 77, -184, 42),
            (28, -163, 84, -161, 36.5),
            (58, -138, 91, -131, 32.5),
            (67, -112, 96, -107, 31),
            (75, -72, 105, -72, 31),
            (74, -51, 117, -34, 40),
            (66, -48, 124, -10, 45.5),
            (58, -48, 122, 18, 47),
            (44, -48, 100, 44, 48),
            (14, -48, 14, 48, 48),
        ),
    ),
    "panel": Loft(
        "yzx",
        (
            (70, -199, 86, -198, 19),
            (74, -182, 92, -180, 24),
            (93, -105, 111, -105, 29),
            (100, -70, 119, -68, 35),
            (98, -45, 125, -45, 44),
            (91, -20, 129, -20, 49.5),
            (84, 0, 130, 0, 50.5),
            (78, 20, 130, 20, 47.5),
            (74, 36, 127, 36, 38),
            (73, 48, 118, 48, 21),
        ),
        exponent=4,
        closed=(True, True),
        segments=14,
    ),
    "inlay": Loft(
        "yzx",
        (
            (86, -164, 99.5, -164, 9.5),
            (92, -140, 105.5, -140, 13),
            (104, -75, 119.5, -75, 16),
            (110, -48, 126, -48, 25),
            (112, -25, 130.5, -25, 34),
            (114, 0, 132, 0, 38),
            (114, 18, 131.8, 18, 34),
            (114, 34, 129.3, 34, 18),
        ),
        exponent=4,
        closed=(True, True),
        segments=14,
    ),
    # link6: the upright tube over the flange, and what joins it to the round joint.
    "wrist": Loft(
        "xyz",
        (
            (44.5, -52, 131.5, -52, 43.5),
            (44, 0, 132, 0, 44),
            (44, 22, 132, 22, 44),
            (46, 46, 131, 42, 43),
            (50, 68, 128, 58, 41),
            (54, 78, 124, 66, 38.5),
        ),
        convex=True,
    ),
    "yoke": Hull(
        (
            (0, 0, -15, 46.5, "z"),
            (0, 0, 29, 46.5, "z"),
            (82, 66, 0, 33, "y"),
            (87, 50, 0, 41, "y"),
            (88, 10, 0, 42.5, "y"),
            (88, -20, 0, 41, "y"),
        ),
        segments=16,
    ),
    "cover": Hull(
        (
            (0, 0, 27, 46, "z"),
            (1, 0, 40, 43, "z"),
            (5, 0, 52, 32, "z"),
            (8, 0, 55, 26, "z"),
            (31, 0, 27, 34, "z"),
            (31, 0, 42, 31, "z"),
            (28, 0, 52, 24, "z"),
            (26, 0, 55, 19, "z"),
        ),
        segments=18,
    ),
    "badge": Hull(
        (
            (1, 0, 50, 24, "z"),
            (2, 0, 56.2, 22.5, "z"),
            (33, 0, 50, 15, "z"),
            (32, 0, 56.2, 13.5, "z"),
        ),
    ),
    "handle": Hull(
        (
            (30, 0, 62, 18, "z"),
            (30, 0, 66, 22, "z"),
            (30, 0, 93, 22, "z"),
            (30, 0, 96, 18, "z"),
            (70, 14, 72, 6, "z"),
            (70, -14, 72, 6, "z"),
            (71, 15, 77, 9, "z"),
            (71, -15, 77, 9, "z"),
            (71, 15, 92, 9, "z"),
            (71, -15, 92, 9, "z"),
            (70, 14, 95.5, 6, "z"),
            (70, -14, 95.5, 6, "z"),
        ),
        segments=12,
    ),
    "hand": Loft(
        "yzx",
        (
            (-79, -7.6, 79, -7.6, 21),
            (-86, -3, 86, -3, 25),
            (-91, 10, 91, 10, 25),
            (-97, 34, 97, 34, 22),
            (-100, 56, 100, 56, 19),
            (-99, 63, 99, 63, 18),
            (-94, 66, 94, 66, 16),
        ),
        exponent=5,
        convex=True,
        segments=20,
    ),
}


def loft(shell: Loft) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices [mm] and the triangles, facing outwards, of a shell of rings."""
    angle = np.linspace(0, 2 * np.pi, shell.segments, endpoint=False)
    across = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** (2 / shell.exponent)
    depth = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** (2 / shell.exponent)
    rings = np.array(shell.rings)[:, None, :]
    middle = (rings[..., 0:2] + rings[..., 2:4]) / 2
    half = (rings[..., 2:4] - rings[..., 0:2]) / 2
    flat = middle + half * across[None, :, None]
    u, v, w = ("xyz".index(axis) for axis in shell.axes)
    points = np.empty((len(rings), shell.segments, 3))
    points[..., [u, v]] = flat
    points[..., w] = rings[..., 4] * depth
    vertices = points.reshape(-1, 3)
    n, count = shell.segments, len(rings)
    k = np.arange(n)
    row = np.arange(count - 1)[:, None] * n
    a, b = (row + k).ravel(), (row + (k + 1) % n).ravel()
    triangles = [np.stack([a, b, b + n], -1), np.stack([a, b + n, a + n], -1)]
    for at_end, ring in ((False, 0), (True, count - 1)):
        if shell.closed[at_end]:
            tip = len(vertices)
            vertices = np.vstack([vertices, points[ring].mean(0)])
            first, second = ring * n + k, ring * n + (k + 1) % n
            lid = [first, second] if at_end else [second, first]
            triangles.append(np.stack([*lid, np.full(n, tip)], -1))
    faces = np.vstack(triangles)
    # Whether rings turn right- or left-handed depends on the axes: make the volume positive.
    a, b, c = (vertices[faces[:, i]] - vertices.mean(0) for i in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c))
    return vertices, faces if volume > 0 else faces[:, ::-1]


def hull(shell: Hull) -> np.ndarray:
    """Return points on the circles [mm]; MuJoCo makes the convex hull."""
    angle = np.linspace(0, 2 * np.pi, shell.segments, endpoint=False)
    points = []
    for x, y, z, radius, normal in shell.circles:
        circle = np.zeros((shell.segments, 3))
        u, v = (i for i in range(3) if i != "xyz".index(normal))
        circle[:, u], circle[:, v] = radius * np.cos(angle), radius * np.sin(angle)
        points.append(circle + (x, y, z))
    return np.vstack(points)


def corners(points: np.ndarray) -> np.ndarray:
    """Return those points that the convex hull needs."""
    points = np.round(points, 1)
    return points[np.sort(ConvexHull(points).vertices)]


def mesh_element(name: str, shell: Loft | Hull) -> str:
    """Return the `<mesh>` of a shell, in millimetres: the file's default scales it to metres."""
    vertices, faces = loft(shell) if isinstance(shell, Loft) else (hull(shell), None)
    if isinstance(shell, Hull) or shell.convex:
        vertices, faces = corners(vertices), None
    numbers = " ".join(f"{x:g}" for x in np.round(vertices, 1).ravel() + 0.0)  # + 0.0: no -0
    text = f'    <mesh name="{name}" vertex="{numbers}"'
    if faces is not None:
        text += f'\n      face="{" ".join(map(str, faces.ravel()))}"'
    return text + "/>\n"


def block() -> str:
    """Return all shells as the lines between `<asset>` and `</asset>`."""
    return "".join(mesh_element(name, shell) for name, shell in SHELLS.items())


if __name__ == "__main__":
    PANDA.write_text(BLOCK.sub(lambda m: m[1] + block() + m[3], PANDA.read_text()))
