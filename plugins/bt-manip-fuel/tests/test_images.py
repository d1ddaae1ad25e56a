"""Images on meshes of SDF models."""

import struct
import zlib

import mujoco
import pytest

from bt_manip.models import load_model

from .fuel_server import model_zip

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


SDF = """<sdf version="1.10"><model name="m"><link name="l"><visual name="v"><geometry>
<mesh><uri>meshes/cube.obj</uri></mesh></geometry>{}</visual></link></model></sdf>"""
ALBEDO = "<material><pbr><metal>\n<albedo_map>{}</albedo_map></metal></pbr></material>"


def compiled(address: str) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    made = load_model(address)
    return mujoco.MjModel.from_xml_string(made.xml, dict(made.assets)), made.warnings


def texture_of(model: mujoco.MjModel) -> list[int]:
    return [int(i) for i in model.mat_texid[model.geom_matid[0]] if i >= 0]


@pytest.mark.parametrize("place", ["meshes/skin.png", "materials/textures/skin.png"])
def test_a_mesh_has_the_image_of_its_material_file(server, place):
    files = {"meshes/cube.obj": unfolded_cube(), place: png(),
             "meshes/cube.mtl": "newmtl skin\nmap_Kd skin.png\n"}  # fmt: skip
    server.add("a", "b", model_zip(SDF.format(""), **files))
    model, warnings = compiled("fuel:a/b")
    assert texture_of(model) == [0]
    assert model.mesh_texcoordnum[0] >= 4
    assert model.mat_rgba[0] == pytest.approx([1, 1, 1, 1])
    assert warnings == ()


def test_a_material_may_lay_an_image_on_a_mesh(server):
    files = {"meshes/cube.obj": unfolded_cube(), "materials/x.png": png()}
    server.add("a", "b", model_zip(SDF.format(ALBEDO.format("materials/x.png")), **files))
    model, warnings = compiled("fuel:a/b")
    assert texture_of(model) == [0] and warnings == ()


@pytest.mark.parametrize(
    "data", [b"\xff\xd8 a photograph", b"", png(10_000, 1), b"\x89PNG\r\n\x1a\n"]
)
def test_an_image_that_mujoco_does_not_take_is_a_warning(server, data):
    files = {"meshes/cube.obj": unfolded_cube(), "x.jpg": data}
    server.add("a", "b", model_zip(SDF.format(ALBEDO.format("x.jpg")), **files))
    model, warnings = compiled("fuel:a/b")
    assert texture_of(model) == []
    assert len(warnings) == 1 and "model.sdf:2: <pbr>" in warnings[0]


def test_a_material_file_reaches_nothing_outside_of_the_model(server, tmp_path):
    (tmp_path / "secret.png").write_bytes(png())
    secret = tmp_path / "secret.png"
    texts = {"one": f"map_Kd {secret}", "two": "map_Kd ../../../../../../../secret.png"}
    for name, text in texts.items():
        files = {"meshes/cube.obj": unfolded_cube(), "meshes/cube.mtl": text}
        server.add("a", name, model_zip(SDF.format(""), **files))
        assert texture_of(compiled(f"fuel:a/{name}")[0]) == []
