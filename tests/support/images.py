"""A cube with an image on its sides."""

import numpy as np

from bt_manip import cell

CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
SIDES = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))


def unfolded_cube(half: float = 0.05) -> str:
    lines = ["mtllib cube.mtl", "usemtl skin"]
    lines += [f"v {half * x} {half * y} {half * z}" for x, y, z in CORNERS]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    for a, b, c, d in SIDES:
        lines += [f"f {a}/1 {b}/2 {c}/3", f"f {a}/1 {c}/3 {d}/4"]
    return "\n".join(lines)


def png(width: int = 2, height: int = 2) -> bytes:
    return cell.png(np.full((height, width, 3), (0x80, 0x40, 0x20), np.uint8))
