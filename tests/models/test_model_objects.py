"""Objects made of models: in a cell, in a tree, in a scene, in a state."""

import json
import os

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.behaviours import Grasp, Hover, Reach, SpawnObject
from bt_manip.bt import Sequence
from bt_manip.cell import Cell, CellError
from bt_manip.cell.objects import Basket, Catalogue, Cube, ModelObject, Table
from bt_manip.exceptions import BtManipError
from bt_manip.models import ModelError
from bt_manip.plugins import load_plugins
from bt_manip.recording.recorder import Recorder
from bt_manip.registry import UnknownPartError
from bt_manip.runner import RunObserver, RunRequest, find_tree, prepare
from bt_manip.runner.reloading import Reloader
from bt_manip.runner.station import build_station
from bt_manip.runner.xml_tree import known_behaviours

from .conftest import bundled_sdf, model_zip

REFERENCE = {
    "cube": "fuel:openrobotics/wood cube 5cm",
    "table": "fuel:OpenRobotics/Table",
    "basket": "fuel:GoogleResearch/Threshold Basket",
}
"""The three models of the reference task."""


@pytest.fixture(scope="module")
def parts():
    return load_plugins().parts


@pytest.fixture
def reference(server):
    """Serve the three models; the cube's origin is on its bottom, as that of Fuel's."""
    cube = bundled_sdf("cube", static=False, raised=0.025)
    server.add("openrobotics", "wood cube 5cm", model_zip(cube), version=2)
    server.add("OpenRobotics", "Table", model_zip(bundled_sdf("table", static=True)), version=3)
    basket = bundled_sdf("basket", static=False)
    server.add("GoogleResearch", "Threshold Basket", model_zip(basket))
    return server


def run(parts, settings, tree="pick_place", **request):
    source = find_tree(tree, {name: parts.trees.get(name) for name in parts.trees})
    recorder = Recorder(tree, 0)
    warnings: list[str] = []
    prepared = prepare(RunRequest(source, settings=settings, **request), parts, warnings.append)
    prepared.execute([recorder])
    return recorder.report(), prepared.station, warnings


def test_pick_place_runs_with_all_three_models_from_fuel(reference, parts):
    report, station, warnings = run(parts, REFERENCE, cycles=2)
    for cycle in report.cycles:
        assert (cycle.status, cycle.placed) == ("SUCCESS", True)
        assert cycle.object == "wood_cube_5cm"
        assert cycle.unexpected_contacts == ()
        assert 0.95 * 50.0 <= cycle.grip_force_n <= 1.2 * 50.0
    assert warnings == []
    kinds = {name: entity.kind for name, entity in station.cell.objects.items()}
    assert kinds == {"table": "fuel:OpenRobotics/Table/3",
                     "basket": "fuel:GoogleResearch/Threshold Basket/1"}  # fmt: skip


def test_pick_place_runs_from_the_cache_when_the_server_is_gone(reference, parts):
    for address in REFERENCE.values():
        ModelObject(address)
    reference.stop()
    reference.stop = lambda: None
    report, _, _ = run(parts, REFERENCE)
    assert report.cycles[0].placed


def test_the_tree_in_python_takes_the_same_settings(reference, parts):
    place = find_tree("pick_place", {n: parts.trees.get(n) for n in parts.trees}).path
    in_python, _, _ = run(parts, REFERENCE, f"{place.with_suffix('.py')}:pick_place")
    assert in_python.state_digest == run(parts, REFERENCE)[0].state_digest


def test_a_table_of_another_height_takes_the_robot_and_the_basket_along(server, parts):
    # 15 mm of the top's half thickness become 165 mm: its surface comes to 1.165 m.
    thick = bundled_sdf("table", static=True).replace("1.5 0.8 0.03", "1.5 0.8 0.33")
    server.add("someone", "thick", model_zip(thick))
    report, station, _ = run(parts, {"table": "fuel:someone/thick"})
    assert station.cell.pose("basket").translation[2] == pytest.approx(1.165, abs=1e-9)
    assert report.cycles[0].placed


def test_a_model_with_its_origin_elsewhere_stands_where_the_old_one_stood(server, parts):
    raised = bundled_sdf("table", static=True, raised=-0.3)
    server.add("someone", "raised", model_zip(raised))
    report, station, _ = run(parts, {"table": "fuel:someone/raised"})
    assert station.cell.pose("table").translation[2] == pytest.approx(0.3, abs=1e-9)
    assert station.cell.pose("basket").translation[2] == pytest.approx(1.015, abs=1e-9)
    assert report.cycles[0].placed


def test_an_address_that_leads_nowhere_is_found_before_anything_runs(server, parts):
    for key in ("cube", "table", "basket"):
        with pytest.raises(BtManipError, match="no such model"):
            run(parts, {key: "fuel:nobody/nothing"})


def test_a_plain_name_is_for_the_tree(parts):
    with pytest.raises(BtManipError, match="has no key 'table'"):
        run(parts, {"table": "bascet"})


def test_a_tree_that_is_edited_leaves_the_scenes_models_alone(parts, tmp_path):
    copy = tmp_path / "task.xml"
    copy.write_text(find_tree("pick_place", {"pick_place": parts.trees.get("pick_place")})
                    .path.read_text())  # fmt: skip
    told: list[str] = []

    class Editor(RunObserver):
        ticks = 0

        def after_tick(self):
            self.ticks += 1
            if self.ticks == 3:
                copy.write_text(copy.read_text().replace("<MoveHome/>", "<MoveHome />"))
                os.utime(copy, (1e9, 1e9))

    source = find_tree(str(copy), {})
    prepared = prepare(RunRequest(source, settings={"table": "bundled:table"}), parts)
    behaviours = known_behaviours(parts)
    editor = Editor()
    prepared.execute([editor, Reloader(source, behaviours, told.append)],
                     stop=lambda: editor.ticks > 6)  # fmt: skip
    assert told == [f"{copy} was edited; the tree begins anew"]


def test_a_model_knows_of_itself_what_the_projects_own_objects_know(server):
    cube, table, basket = Cube(), Table(), Basket()
    server.add("a", "cube", model_zip(bundled_sdf("cube", static=False)))
    server.add("a", "table", model_zip(bundled_sdf("table", static=True)))
    made = ModelObject("fuel:a/cube")
    assert (made.free, made.category) == (True, "graspable")
    assert made.mass == pytest.approx(cube.mass)
    assert made.rest_height == pytest.approx(cube.rest_height)
    assert made.centre_offset == pytest.approx(np.zeros(3), abs=1e-12)
    made = ModelObject("fuel:a/table")
    assert (made.free, made.category) == (False, "surface")
    assert made.surface_height == pytest.approx(table.surface_height)
    made = ModelObject("bundled:basket", category="container")
    assert made.mass == pytest.approx(basket.mass)
    assert (made.category, made.surface_height) == ("container", None)


def test_mass_friction_and_colour_can_be_changed(server):
    server.add("a", "cube", model_zip(bundled_sdf("cube", static=False)))
    for address in ("fuel:a/cube", "bundled:cube"):
        cell = Cell()
        thing = ModelObject(address, mass=2.0, friction=0.3, colour=(1, 0, 0))
        name = cell.add(thing, spatial.pose((0, 0, 1)))
        body = cell.body_id(name)
        assert thing.mass == 2.0
        assert cell.model.body_subtreemass[body] == pytest.approx(2.0)
        inertia = 2.0 / 6 * 0.05**2  # of a solid cube
        child = int(np.argmax(cell.model.body_mass))
        assert cell.model.body_inertia[child] == pytest.approx([inertia] * 3)
        touch = (cell.model.geom_contype != 0) & (cell.model.geom_bodyid == child)
        assert cell.model.geom_friction[touch, 0] == pytest.approx(0.3)


@pytest.mark.parametrize("mass", [0.0, -1.0, float("nan"), float("inf")])
def test_a_mass_that_is_none_is_refused(mass):
    with pytest.raises(CellError, match="mass must be a positive number"):
        ModelObject("bundled:cube", mass=mass)


def test_a_model_with_its_origin_far_away_is_spawned_and_grasped_by_its_middle(server, parts):
    sdf = bundled_sdf("cube", static=False).replace(
        "<link name='link'><pose>0 0 0.0 0 0 0</pose>",
        "<link name='link'><pose>0.4 -0.3 0.2 0 0 0</pose>",
    )
    server.add("a", "cube", model_zip(sdf))
    station = build_station(parts, seed=3)
    region = "0.3;0.3;0.1;0.1"
    tree = Sequence("grasp it", [
        SpawnObject(model="fuel:a/cube", region=region, object="{o}"),
        Hover(object="{o}", height=0.2), Reach(object="{o}"), Grasp(object="{o}"),
    ])  # fmt: skip
    assert station.run(tree).status.name == "SUCCESS"
    middle = station.cell.pose("cube").act(np.array([0.4, -0.3, 0.2]))
    assert middle == pytest.approx([0.3, 0.1, 1.04], abs=3e-3)


def test_a_state_makes_the_models_again(server, parts):
    server.add("a", "cube", model_zip(bundled_sdf("cube", static=False)), version=4)
    station = build_station(parts)
    thing = station.models.create("fuel:a/cube", friction=0.5)
    station.cell.add(thing, spatial.pose((0.3, 0.0, 1.2)))
    station.cell.step(50)
    state = json.loads(json.dumps(station.get_state()))
    server.add("a", "cube", b"broken", version=5)  # a newer one is none of the state's business
    again = build_station(parts)
    again.set_state(state)
    assert again.cell.find("cube").kind == "fuel:a/cube/4"
    for one in (station, again):
        one.cell.step(100)
    assert station.cell.state_bytes() == again.cell.state_bytes()


def test_a_name_or_an_address_makes_an_object(parts):
    catalogue = Catalogue(parts.objects)
    assert isinstance(catalogue.create("cube"), Cube)
    assert isinstance(catalogue.create("bundled:cube"), ModelObject)
    with pytest.raises(UnknownPartError, match="did you mean 'cube'"):
        catalogue.get("cub")
    with pytest.raises(ModelError, match="did you mean 'cube'"):
        catalogue.get("bundled:cub")


def test_a_hollow_mesh_is_hollow_as_a_container(tmp_path, monkeypatch, parts):
    import trimesh

    from bt_manip.cell.objects import catalogue as module
    from bt_manip.models import convex
    from bt_manip.models.meshes import Mesh

    monkeypatch.setenv("BT_MANIP_CACHE", str(tmp_path / "kept"))
    walls = [trimesh.creation.box((0.2, 0.2, 0.02)).apply_translation((0, 0, 0.01))]
    for x, y in ((0.09, 0), (-0.09, 0), (0, 0.09), (0, -0.09)):
        size = (0.02 if x else 0.2, 0.02 if y else 0.2, 0.1)
        walls.append(trimesh.creation.box(size).apply_translation((x, y, 0.05)))
    trimesh.util.concatenate(walls).export(tmp_path / "bin.stl")
    mesh = "<geometry><mesh><uri>bin.stl</uri></mesh></geometry>"
    path = tmp_path / "bin.sdf"
    path.write_text(f"""<sdf version="1.10"><model name="bin"><link name="l">
        <collision name="c">{mesh}</collision></link></model></sdf>""")

    monkeypatch.setattr(module, "can_decompose", lambda: False)
    solid = Catalogue(parts.objects)
    assert rests_at(solid.create(str(path), category="container")) == pytest.approx(0.125, abs=5e-3)
    assert len(solid.warnings()) == 1 and "bt-manip[convex]" in solid.warnings()[0]

    # The real search takes minutes with such a mesh; test_sdf.py does one with a smaller one.
    parts_found = [Mesh(np.asarray(w.vertices), np.asarray(w.faces)) for w in walls]
    monkeypatch.setattr(module, "can_decompose", lambda: True)
    monkeypatch.setattr(convex, "_decompose", lambda mesh: parts_found)
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


BAD = {
    "fuell:a/b": "unknown kind of address 'fuell:'; did you mean 'fuel:'?",
    "nowhere/thing.sdf": "there is no such file",
    "bundled:cub": "did you mean 'cube'",
    "package://nobody/x.urdf": "no package 'nobody'",
    "menagerie:franka": "did you mean 'franka_",
    "holed.stl": "not watertight",
    "massless.sdf": "massless.sdf:2: link 'l': a mass must be a positive number",
    "negative.sdf": "a mass must be a positive number [kg], got -1",
    "text.txt": "not a model; one is",
    "broken.xml": "broken.xml:1:",
    "wrong.xml": "MuJoCo refuses it|cannot be read",
}


@pytest.mark.parametrize("address", BAD)
def test_bad_input_is_one_error_and_the_cell_is_unchanged(address, tmp_path, monkeypatch, parts):
    import trimesh

    monkeypatch.chdir(tmp_path)
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    box.update_faces(np.arange(10))
    box.export(tmp_path / "holed.stl")
    sdf = "<sdf version='1.9'><model name='m'>\n<link name='l'><inertial><mass>{}</mass></inertial>"
    (tmp_path / "massless.sdf").write_text(f"{sdf.format(0)}</link></model></sdf>")
    (tmp_path / "negative.sdf").write_text(f"{sdf.format(-1)}</link></model></sdf>")
    (tmp_path / "text.txt").touch()
    (tmp_path / "broken.xml").write_text("<mujoco>")
    (tmp_path / "wrong.xml").write_text(
        "<mujoco><worldbody><geom type='bal'/></worldbody></mujoco>"
    )
    cell = Cell()
    cell.add(Cube(), spatial.pose((0, 0, 0.5)))
    before = cell.state_bytes(), cell.generation, dict(cell.objects)
    with pytest.raises(BtManipError) as caught:
        cell.add(Catalogue(parts.objects).create(address), spatial.pose((0, 0, 2)))
    words = BAD[address].split("|")
    assert any(word in str(caught.value) for word in words), caught.value
    assert len(str(caught.value).splitlines()) == 1
    assert (cell.state_bytes(), cell.generation, dict(cell.objects)) == before


def test_angles_in_degrees_stay_what_they_are_in_a_cell(tmp_path):
    path = tmp_path / "degrees.xml"
    path.write_text("""<mujoco><worldbody><body name="a"><inertial pos="0 0 0" mass="1"
        diaginertia="1 1 1"/><geom size="0.1"/><body name="b" euler="90 0 0"><joint name="j"
        range="-30 60"/><geom size="0.1" pos="0 0.3 0"/></body></body></worldbody></mujoco>""")
    cell = Cell()
    name = cell.add(ModelObject(str(path)), spatial.pose((0, 0, 1)))
    assert cell.model.jnt_range[0] == pytest.approx(np.radians([-30, 60]), rel=1e-14)
    quat = cell.model.body(f"{name}/b").quat
    assert quat == pytest.approx([0.5**0.5, 0.5**0.5, 0, 0])


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


def test_bounds_are_exact_for_turned_shapes(tmp_path):
    from bt_manip.cell.objects.bounds import bounds_of

    xml = """<mujoco><worldbody><geom type="{}" size="{}" pos="1 2 3" euler="20 30 40"/>
        </worldbody></mujoco>"""
    shapes = {"box": ".1 .2 .3", "sphere": ".2", "capsule": ".1 .3", "cylinder": ".1 .3",
              "ellipsoid": ".1 .2 .3"}  # fmt: skip
    rng = np.random.default_rng(0)
    for kind, size in shapes.items():
        model = mujoco.MjModel.from_xml_string(xml.format(kind, size))
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        bounds = bounds_of(model)
        # The farthest of many points of the shape comes near the box, and none leaves it.
        points = _points(kind, np.array([float(s) for s in size.split()]), rng)
        points = points @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
        assert (points >= bounds.lower - 1e-9).all() and (points <= bounds.upper + 1e-9).all()
        assert points.min(axis=0) == pytest.approx(bounds.lower, abs=4e-3)
        assert points.max(axis=0) == pytest.approx(bounds.upper, abs=4e-3)


def _points(kind: str, size: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    sphere = rng.standard_normal((20_000, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    if kind == "box":
        return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
    if kind == "sphere":
        return sphere * size[0]
    if kind == "ellipsoid":
        return sphere * size
    ends = rng.choice([-1.0, 1.0], 20_000)[:, None] * [0, 0, size[1]]
    if kind == "capsule":
        return sphere * size[0] + ends
    flat = sphere * [1, 1, 0]
    return flat / np.linalg.norm(flat, axis=1, keepdims=True) * size[0] + ends


@pytest.mark.parametrize("by", ["a catalogue", "itself"])
def test_a_misspelt_category_is_refused_with_the_nearest_one(parts, by):
    make = ModelObject if by == "itself" else Catalogue(parts.objects).create
    with pytest.raises(CellError, match="category 'contaner' is none; did you mean 'container'"):
        make("bundled:basket", category="contaner")


def test_a_category_that_only_an_object_of_a_plugin_has_is_one(parts):
    catalogue = Catalogue(parts.objects)
    if "sorting_tray" not in parts.objects:
        parts.objects.add("lonely", type("Lonely", (), {"category": "tray"}), "test")
    assert catalogue.create("bundled:basket", category="tray").category == "tray"
    with pytest.raises(CellError, match="category 'fixture' is none; known: button, container|did"):
        catalogue.create("bundled:basket", category="fixture")
