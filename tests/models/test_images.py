"""Images on meshes, and meshes whose corners differ in their place on an image."""

import struct
import zlib

import mujoco
import pytest

from bt_manip.models import load_model
from bt_manip.models.images import read_png

CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
SIGNATURE = b"\x89PNG\r\n\x1a\n"
SIDES = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))


def unfolded_cube(half: float = 0.05) -> str:
    lines = ["mtllib cube.mtl", "usemtl skin"]
    lines += [f"v {half * x} {half * y} {half * z}" for x, y, z in CORNERS]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    for a, b, c, d in SIDES:
        lines += [f"f {a}/1 {b}/2 {c}/3", f"f {a}/1 {c}/3 {d}/4"]
    return "\n".join(lines)


def png(width: int = 2, height: int = 2) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + check

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    rows = b"".join(b"\0" + b"\x80\x40\x20" * width for _ in range(height))
    data = zlib.compress(rows)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    )


def compiled(address: str) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    made = load_model(address)
    return mujoco.MjModel.from_xml_string(made.xml, dict(made.assets)), made.warnings


def texture_of(model: mujoco.MjModel) -> list[int]:
    return [int(i) for i in model.mat_texid[model.geom_matid[0]] if i >= 0]


def test_seams_of_an_image_are_no_holes(tmp_path):
    (tmp_path / "cube.obj").write_text(unfolded_cube())
    (tmp_path / "cube.mtl").write_text("map_Kd skin.png")
    (tmp_path / "skin.png").write_bytes(png())
    model, _ = compiled(str(tmp_path / "cube.obj"))
    assert model.body_mass[1] == pytest.approx(1000 * 0.1**3, rel=1e-6)
    assert texture_of(model) == [0]


def test_no_png_is_none(tmp_path):
    assert read_png(tmp_path / "nowhere.png") is None
