"""Images on meshes of SDF models."""

import mujoco
import pytest

from tests.support.images import png, unfolded_cube

from .fuel_server import compiled, model_zip

SDF = """<sdf version="1.10"><model name="m"><link name="l"><visual name="v"><geometry>
<mesh><uri>meshes/cube.obj</uri></mesh></geometry>{}</visual></link></model></sdf>"""
ALBEDO = "<material><pbr><metal>\n<albedo_map>{}</albedo_map></metal></pbr></material>"


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
