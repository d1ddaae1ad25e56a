"""Objects made of models: in a cell, in a tree, in a scene, in a state."""

import os
from pathlib import Path

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.cell import Cell, CellError
from bt_manip.cell.objects import Catalogue, Cube, ModelObject
from bt_manip.exceptions import BtManipError
from bt_manip.models import ModelError, load_model
from bt_manip.plugins import load_plugins
from bt_manip.registry import UnknownPartError
from bt_manip.runner import RunObserver, RunRequest, find_tree, prepare
from bt_manip.runner.reloading import Reloader
from bt_manip.runner.xml_tree import known_behaviours


@pytest.fixture(scope="module")
def parts():
    return load_plugins().parts


def test_a_plain_name_is_for_the_tree(parts):
    source = find_tree("pick_place", {"pick_place": parts.trees.get("pick_place")})
    with pytest.raises(BtManipError, match="has no key 'table'"):
        prepare(RunRequest(source, settings={"table": "bascet"}), parts)


def test_a_tree_that_is_edited_leaves_the_scenes_models_alone(parts, tmp_path):
    copy = tmp_path / "task.xml"
    copy.write_text(Path(parts.trees.get("pick_place")).read_text())
    told: list[str] = []

    class Editor(RunObserver):
        ticks = 0

        def after_tick(self):
            self.ticks += 1
            if self.ticks == 3:
                copy.write_text(copy.read_text().replace("<MoveHome/>", "<MoveHome />"))
                os.utime(copy, (1e9, 1e9))

    source, editor = find_tree(str(copy), {}), Editor()
    prepared = prepare(RunRequest(source, settings={"table": "bundled:table"}), parts)
    reloader = Reloader(source, known_behaviours(parts), told.append)
    prepared.execute([editor, reloader], stop=lambda: editor.ticks > 6)
    assert told == [f"{copy} was edited; the tree begins anew"]


def test_friction_and_colour_can_be_changed():
    cell, thing = Cell(), ModelObject("bundled:cube", friction=0.3, colour=(1, 0.5, 0))
    cell.add(thing, spatial.pose((0, 0, 1)))
    model = cell.model
    touch, mine = (model.geom_contype | model.geom_conaffinity) != 0, model.geom_bodyid > 0
    assert model.geom_friction[touch & mine, 0] == pytest.approx(0.3)
    np.testing.assert_allclose(model.geom_rgba[mine & ~touch], [(1, 0.5, 0, 1)])


@pytest.mark.parametrize("mass", [0.0, float("nan"), 1e300])
def test_a_mass_that_is_none_is_refused(mass):
    with pytest.raises(CellError, match="mass must be a number above 0 and at most"):
        ModelObject("bundled:cube", mass=mass)


MJCF = "<mujoco><worldbody><body>\n{}</body></worldbody></mujoco>"
URDF = '<robot name="r"><link name="l"><inertial>{}</inertial>{}</link></robot>'
SPHERE = '<collision><geometry><sphere radius=".02"/></geometry></collision>'
UNIT = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
BALL = '<geom size=".02"/>'
INERTIAL = {
    "mass.xml": MJCF.format('<inertial mass="{}" pos="0 0 0" diaginertia="1 1 1"/>' + BALL),
    "inertia.xml": MJCF.format('<inertial mass="1" pos="0 0 0" diaginertia="{} 1 1"/>' + BALL),
    "geom.xml": MJCF.format('<geom size=".02" mass="{}"/>'),
    "density.xml": MJCF.format('<geom size=".02" density="{}"/>'),
    "mass.urdf": URDF.format('\n<mass value="{}"/>' + UNIT, SPHERE),
    "inertia.urdf": URDF.format('<mass value="1"/>\n' + UNIT.replace('"1"', '"{}"', 1), ""),
}


@pytest.mark.parametrize("value", ["-1", "1e300", "nan"])
@pytest.mark.parametrize("name", INERTIAL)
def test_impossible_masses_and_inertias_are_refused_with_their_line(tmp_path, name, value):
    path = tmp_path / name
    path.write_text(INERTIAL[name].format(value))
    with pytest.raises(ModelError, match=rf"{name}:2: .* at least 0 and at most 1e\+10 .*{value}"):
        load_model(str(path)) and ModelObject(str(path))


@pytest.mark.parametrize("name", [name for name in INERTIAL if "inertia" not in name])
def test_a_body_without_mass_may_not_move(tmp_path, name):
    path = tmp_path / name
    path.write_text(INERTIAL[name].format(0))
    cell = Cell()
    with pytest.raises(
        CellError, match="^'x' cannot be added: 'x' moves, so it needs a positive mass"
    ):
        cell.add(ModelObject(str(path)), spatial.pose((0, 0, 1)), name="x")
    cell.add(ModelObject(str(path)), spatial.pose((0, 0, 1)), name="x", free=False)


def test_a_name_or_an_address_makes_an_object(parts):
    catalogue = Catalogue(parts.objects)
    assert isinstance(catalogue.create("cube"), Cube)
    assert isinstance(catalogue.create("bundled:cube"), ModelObject)
    with pytest.raises(UnknownPartError, match="did you mean 'cube'"):
        catalogue.get("cub")
    with pytest.raises(ModelError, match="not by 'sphere'"):
        load_model("bundled:cube", convex="sphere")


def test_a_hollow_mesh_is_hollow_as_a_container(tmp_path, monkeypatch, parts):
    import trimesh

    from bt_manip.cell.objects import catalogue as module
    from bt_manip.models import convex
    from bt_manip.models.meshes import Mesh

    monkeypatch.setenv("BT_MANIP_CACHE", str(tmp_path / "kept"))
    walls = [trimesh.creation.box((0.2, 0.2, 0.02)).apply_translation((0, 0, 0.01))]
    for x, y in ((0.09, 0), (-0.09, 0), (0, 0.09), (0, -0.09)):
        size = (0.02 if x else 0.158, 0.02 if y else 0.199, 0.1)  # no corner in common
        walls.append(trimesh.creation.box(size).apply_translation((x, y, 0.051)))
    trimesh.util.concatenate(walls).export(tmp_path / "bin.stl")
    path = tmp_path / "bin.stl"

    monkeypatch.setattr(module, "can_decompose", lambda: False)
    solid = Catalogue(parts.objects)
    assert rests_at(solid.create(str(path), category="container", mass=2.0)) == pytest.approx(
        0.125, abs=5e-3
    )
    assert len(solid.warnings()) == 1 and "bt-manip[convex]" in solid.warnings()[0]

    # The real search takes minutes with such a mesh.
    parts_found = [Mesh(np.asarray(w.vertices), np.asarray(w.faces)) for w in walls]
    monkeypatch.setattr(module, "can_decompose", lambda: True)
    monkeypatch.setattr(convex, "decompose", lambda mesh: parts_found)
    hollow = Catalogue(parts.objects).create(str(path), category="container")
    assert hollow.parameters["convex"] == "parts"
    assert rests_at(hollow) == pytest.approx(0.045, abs=5e-3)


def rests_at(container: ModelObject) -> float:
    """Let a cube of 5 cm fall into a container on the floor; give the height of its middle [m]."""
    cell = Cell()
    cell.add(container, free=False)
    cell.add(Cube(), spatial.pose((0, 0, 0.15)), name="cube")
    cell.step(600)
    return float(cell.pose("cube").translation[2])


def test_a_model_with_a_free_joint_of_its_own_is_free(tmp_path):
    path = tmp_path / "loose.xml"
    path.write_text("""<mujoco><compiler angle="radian"/><option timestep="0.5"/><worldbody>
        <light/><body><freejoint/><geom size="0.4" mass="20"/></body></worldbody></mujoco>""")
    thing = ModelObject(str(path))
    assert thing.free
    cell = Cell()
    cell.add(thing, spatial.pose((0, 0, 2)))
    assert cell.model.nv == 6
    assert cell.model.opt.timestep == 1e-3


def test_a_misspelt_category_is_refused_and_one_of_an_object_of_a_plugin_is_one(parts):
    with pytest.raises(CellError, match="category 'contaner' is none; did you mean 'container'"):
        ModelObject("bundled:basket", category="contaner")
    catalogue = Catalogue(parts.objects)
    if "sorting_tray" not in parts.objects:
        parts.objects.add("lonely", type("Lonely", (), {"category": "tray"}), "test")
    assert catalogue.create("bundled:basket", category="tray").category == "tray"
    with pytest.raises(CellError, match="category 'fixture' is none; known: button, container|did"):
        catalogue.create("bundled:basket", category="fixture")
