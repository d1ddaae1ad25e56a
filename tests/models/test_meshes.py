"""Meshes are read in metres with z up, and as the solids that their surfaces enclose."""

import re
import time

import mujoco
import numpy as np
import pytest
import trimesh
from trimesh.exchange.dae import export_collada

from bt_manip.cell.objects import ModelObject
from bt_manip.models import Mesh, ModelError, convex, convex_parts, load_model, read_mesh
from bt_manip.models.images import read_png
from tests.support.images import png, unfolded_cube

SIZE = np.array([0.04, 0.06, 0.05])  # [m]
WEDGE = "v 0 0 0\nv .04 0 0\nv 0 .06 0\nv 0 0 .05\n"  # 0.04 * 0.06 * 0.05 / 6 m3
OUTWARDS = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
INWARDS = "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"


def volume(mesh: Mesh) -> float:
    return float(trimesh.Trimesh(mesh.vertices, mesh.faces).volume)


def write_parts(path, first: str, second: str) -> None:
    """Write boxes of two colours, the second one mirrored in the plane x = 4 m, as COLLADA."""
    boxes = [trimesh.creation.box(size).apply_translation((0.5, 0, 0)) for size in BOXES.values()]
    text = export_collada(boxes).decode()
    for name, old in zip(BOXES, re.findall(r'<geometry id="(\w+)"', text), strict=True):
        text = text.replace(old, name)
    for colour in (first, second):
        text = re.sub(r"(<diffuse>\s*<color>)0\.0 0\.0 0\.0 1\.0", rf"\g<1>{colour}", text, count=1)
    mirror = "<matrix>-1 0 0 8 0 1 0 0 0 0 1 0 0 0 0 1</matrix>"
    path.write_text(text.replace('name="node1">', f'name="node1">{mirror}'))


BOXES = {"large": (1.0, 2.0, 3.0), "small": (0.4, 0.5, 0.6)}  # [m]; y of the file is up


def test_parts_of_a_scene_are_joined_where_they_are_or_read_alone(tmp_path):
    path = tmp_path / "a.dae"
    write_parts(path, "0.2 0.4 0.6 1.0", "0.2 0.4 0.6 1.0")
    mesh, small = read_mesh(path), read_mesh(path, "small")
    assert mesh.watertight and volume(mesh) == pytest.approx(1 * 2 * 3 + 0.4 * 0.5 * 0.6)
    assert mesh.vertices.min(axis=0) == pytest.approx([0.0, -1.5, -1.0])
    assert mesh.vertices.max(axis=0) == pytest.approx([7.7, 1.5, 1.0])
    assert mesh.colour == pytest.approx((0.2, 0.4, 0.6, 1.0))
    assert volume(small) == pytest.approx(0.4 * 0.5 * 0.6)
    assert small.vertices.min(axis=0) == pytest.approx([7.3, -0.3, -0.25])
    with pytest.raises(ModelError, match="no part 'smal'; did you mean 'small'"):
        read_mesh(path, "smal")
    write_parts(path, "0.2 0.4 0.6 1.0", "0.2 0.4 0.8 1.0")
    assert read_mesh(path).colour is None


@pytest.mark.parametrize(("axis", "right", "up", "out"), [  # COLLADA 1.4.1, up_axis
    ("X_UP", (0, -1, 0), (1, 0, 0), (0, 0, 1)), ("Y_UP", (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    ("Z_UP", (1, 0, 0), (0, 0, 1), (0, -1, 0)), ("", (1, 0, 0), (0, 1, 0), (0, 0, 1)),
])  # fmt: skip
def test_collada_is_read_in_metres_with_x_to_the_right_and_z_up(tmp_path, axis, right, up, out):
    axes = np.array([right, up, out, (0, 0, 0)], dtype=float)
    faces = [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]
    text = export_collada(trimesh.Trimesh(axes, faces, process=False)).decode()
    head = f'<unit name="inch" meter="0.0254"/><up_axis>{axis}</up_axis>'
    text = re.sub(r"<up_axis>.*</up_axis>", head, re.sub(r"<unit[^>]*/>", "", text))
    (tmp_path / "a.dae").write_text(text)
    expected = 0.0254 * np.array([(1, 0, 0), (0, 0, 1), (0, -1, 0), (0, 0, 0)])
    vertices = read_mesh(tmp_path / "a.dae").vertices
    assert np.unique(vertices.round(9), axis=0) == pytest.approx(np.unique(expected, axis=0))
    (tmp_path / "a.dae").write_text(text.replace("0.0254", "1-2"))
    assert read_mesh(tmp_path / "a.dae").vertices == pytest.approx(vertices / 0.0254)
    (tmp_path / "a.dae").write_text(text.replace("0.0254", "nan"))
    with pytest.raises(ModelError, match="with non-finite points"):
        read_mesh(tmp_path / "a.dae")


def test_a_mesh_is_written_as_it_is_read_and_mirrored_with_its_faces(tmp_path, rng):
    corners = rng.normal(size=(4, 3)) * [0.1, 0.2, 0.3] + [0.5, 0.0, 0.0]
    hull = trimesh.convex.convex_hull(corners)
    part = Mesh(np.array(hull.vertices), np.array(hull.faces))
    mesh = Mesh(part.vertices, part.faces, uv=rng.uniform(size=(4, 2)), convex_parts=(part,))
    (tmp_path / "a.obj").write_bytes(mesh.to_obj())
    again = read_mesh(tmp_path / "a.obj")
    for name in ("vertices", "uv"):
        seen = getattr(again, name)[again.faces]
        assert seen == pytest.approx(getattr(mesh, name)[mesh.faces], abs=1e-7)
    assert again.watertight
    mirrored = mesh.scaled(np.array([2.0, -3.0, 1.5]))
    assert mirrored.vertices == pytest.approx(mesh.vertices * [2.0, -3.0, 1.5])
    for solid in (mirrored, *mirrored.convex_parts):
        assert volume(solid) == pytest.approx(9.0 * hull.volume)


def test_a_mesh_may_be_moved_so_that_its_bounding_box_is_around_the_origin(tmp_path):
    path = tmp_path / "a.stl"
    trimesh.creation.cone(0.05, 0.06).apply_translation((0.01, 0.2, -0.3)).export(path)
    half = np.ptp(read_mesh(path).vertices, axis=0) / 2
    centred = read_mesh(path, centred=True).vertices
    assert (*centred.min(axis=0), *centred.max(axis=0)) == pytest.approx((*-half, *half))


@pytest.mark.parametrize("faces", [OUTWARDS, INWARDS])
def test_a_mesh_weighs_as_its_volume_either_side_out(tmp_path, faces):
    (tmp_path / "wedge.obj").write_text(WEDGE + faces)
    assert ModelObject(f"{tmp_path}/wedge.obj").mass == pytest.approx(1000 * SIZE.prod() / 6)


@pytest.mark.parametrize("scale", ["1 -2 1", "-1 -1 -1"])
def test_a_mirrored_mesh_of_urdf_weighs_as_its_volume(tmp_path, scale):
    (tmp_path / "wedge.obj").write_text(WEDGE + OUTWARDS)
    shape = f'<geometry><mesh filename="wedge.obj" scale="{scale}"/></geometry>'
    path, factors = tmp_path / "m.urdf", np.array([float(word) for word in scale.split()])
    path.write_text(f'<robot name="m"><link name="b"><collision>{shape}</collision></link></robot>')
    model = ModelObject(model=str(path))
    assert model.mass == pytest.approx(1000 * SIZE.prod() / 6 * abs(factors.prod()))
    assert model.centre_offset == pytest.approx(0.5 * factors * SIZE, abs=1e-6)


@pytest.mark.parametrize(("depth", "parts"), [(0.03, 2), (0.09, 0)])
def test_groups_are_convex_parts_if_each_has_98_percent_of_the_volume_of_its_hull(
    tmp_path, depth, parts
):
    """A dent in a face of a unit cube takes a third of its depth [m3]."""
    sides = "1 2 4 3|5 7 8 6|1 5 6 2|3 4 8 7|1 3 7 5|2 6 9|6 8 9|8 4 9|4 2 9".split("|")
    lines = []
    for group in range(2):
        corners = [*np.ndindex(2, 2, 2), (0.5, 0.5, 1 - depth)]
        lines += [f"o {group}", *(f"v {x + 2 * group} {y} {z}" for x, y, z in corners)]
        lines += ["f " + " ".join(str(int(i) + 9 * group) for i in side.split()) for side in sides]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    mesh = read_mesh(tmp_path / "a.obj")
    assert len(mesh.convex_parts) == parts and volume(mesh) == pytest.approx(2 - 2 * depth / 3)


def test_a_polygon_or_a_number_of_groups_of_absurd_size_is_refused_or_not_looked_at(tmp_path):
    path = tmp_path / "groups.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + " 1 2 3" * 20_000)
    with pytest.raises(ModelError, match="a line of more than 65536 characters"):
        read_mesh(path)
    box = trimesh.creation.box()
    many = trimesh.Trimesh(box.vertices, np.tile(box.faces, (150, 1)), process=False)
    many.export(tmp_path / "many.stl")  # 90 kB without an end of a line
    assert len(read_mesh(tmp_path / "many.stl").faces) == 1800
    start = time.monotonic()
    path.write_text(WEDGE + f"o one\n{OUTWARDS}" * 1001)
    assert read_mesh(path).convex_parts == ()
    assert time.monotonic() - start < 4.0


def test_convex_parts_are_searched_once_and_then_read_from_the_cache(tmp_path, monkeypatch, rng):
    meshes = [Mesh(rng.normal(size=(n, 3)), rng.integers(n, size=(n + 2, 3))) for n in (4, 5, 6)]
    searched = []
    monkeypatch.setenv("BT_MANIP_CACHE", str(tmp_path))
    monkeypatch.setattr(convex, "decompose", lambda mesh: searched.append(mesh) or meshes[:2])
    for _ in range(2):
        for mesh in meshes[1:]:
            for part, given in zip(convex_parts(mesh), meshes, strict=False):
                assert (part.vertices == given.vertices).all() and (part.faces == given.faces).all()
    assert searched == meshes[1:]


def test_seams_of_an_image_are_no_holes(tmp_path):
    (tmp_path / "cube.obj").write_text(unfolded_cube())
    (tmp_path / "cube.mtl").write_text("map_Kd skin.png")
    (tmp_path / "skin.png").write_bytes(png())
    made = load_model(str(tmp_path / "cube.obj"))
    model = mujoco.MjModel.from_xml_string(made.xml, dict(made.assets))
    assert model.body_mass[1] == pytest.approx(1000 * 0.1**3, rel=1e-6)
    assert [i for i in model.mat_texid[model.geom_matid[0]] if i >= 0] == [0]
    assert read_png(tmp_path / "nowhere.png") is None
