"""Objects made of models of Fuel: in a cell, in a tree, in a scene, in a state."""

import json
from pathlib import Path

import numpy as np
import pytest
from requests import Session

from bt_manip import build_station, spatial
from bt_manip.behaviours import Grasp, Hover, Reach, SpawnObject
from bt_manip.bt import Sequence
from bt_manip.cell import Cell
from bt_manip.cell.objects import Basket, Cube, ModelObject, Table
from bt_manip.exceptions import BtManipError
from bt_manip.runner import prepare, request_of

from .fuel_server import bundled_sdf, model_zip

REFERENCE = {
    "cube": "fuel:openrobotics/wood cube 5cm",
    "table": "fuel:OpenRobotics/Table",
    "basket": "fuel:GoogleResearch/Threshold Basket",
}
"""The three models of the reference task."""


@pytest.fixture
def reference(server):
    """Serve the three models; the cube's origin is on its bottom, as that of Fuel's."""
    cube = bundled_sdf("cube", static=False, raised=0.025)
    server.add("openrobotics", "wood cube 5cm", model_zip(cube), version=2)
    server.add("OpenRobotics", "Table", model_zip(bundled_sdf("table", static=True)), version=3)
    basket = bundled_sdf("basket", static=False)
    server.add("GoogleResearch", "Threshold Basket", model_zip(basket))
    return server


def prepared(parts, settings, tree="pick_place"):
    """Prepare a run of a tree; nothing is warned of."""
    return prepare(request_of(tree, parts, settings=settings), parts, pytest.fail)


def test_pick_place_has_models_from_fuel_and_runs_from_the_cache_when_the_server_is_gone(
    reference, parts
):
    run = prepared(parts, REFERENCE)
    kinds = {name: entity.kind for name, entity in run.station.cell.objects.items()}
    assert kinds == {"table": "fuel:OpenRobotics/Table/3",
                     "basket": "fuel:GoogleResearch/Threshold Basket/1"}  # fmt: skip
    reference.stop()
    reference.stop = lambda: None
    tree = Path(parts.trees.get("pick_place")).with_suffix(".py")
    in_python = prepared(parts, REFERENCE, f"{tree}:pick_place")
    in_python.execute([])
    assert in_python.goal.holds


def test_a_table_of_another_height_or_origin_takes_the_robot_and_the_basket_along(server, parts):
    # 15 mm of the top's half thickness become 165 mm: its surface comes to 1.165 m.
    thick = bundled_sdf("table", static=True).replace("1.5 0.8 0.03", "1.5 0.8 0.33")
    server.add("someone", "thick", model_zip(thick))
    run = prepared(parts, {"table": "fuel:someone/thick"})
    assert run.station.cell.pose("basket").translation[2] == pytest.approx(1.165, abs=1e-9)
    run.execute([])
    assert run.goal.holds
    server.add("someone", "raised", model_zip(bundled_sdf("table", static=True, raised=-0.3)))
    cell = prepared(parts, {"table": "fuel:someone/raised"}).station.cell
    assert cell.pose("table").translation[2] == pytest.approx(0.3, abs=1e-9)
    assert cell.pose("basket").translation[2] == pytest.approx(1.015, abs=1e-9)


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
    cell = Cell()
    thing = ModelObject("fuel:a/cube", mass=2.0, friction=0.3, colour=(1, 0, 0))
    name = cell.add(thing, spatial.pose((0, 0, 1)))
    assert thing.mass == 2.0
    assert cell.model.body_subtreemass[cell.body_id(name)] == pytest.approx(2.0)
    child = int(np.argmax(cell.model.body_mass))
    inertia = 2.0 / 6 * 0.05**2  # of a solid cube
    assert cell.model.body_inertia[child] == pytest.approx([inertia] * 3)
    touch = (cell.model.geom_contype != 0) & (cell.model.geom_bodyid == child)
    assert cell.model.geom_friction[touch, 0] == pytest.approx(0.3)


@pytest.mark.parametrize("mass", [0, -1])
def test_a_refused_model_leaves_the_cell_unchanged(tmp_path, mass):
    path = tmp_path / "massless.sdf"
    path.write_text(f"""<sdf version='1.9'><model name='m'>
        <link name='l'><inertial><mass>{mass}</mass></inertial></link></model></sdf>""")
    cell = Cell()
    cell.add(Cube(), spatial.pose((0, 0, 0.5)))
    before = cell.state_bytes(), cell.generation, dict(cell.objects)
    with pytest.raises(BtManipError, match="massless.sdf:2: link 'l': a mass must be a positive"):
        cell.add(ModelObject(str(path)), spatial.pose((0, 0, 2)))
    assert (cell.state_bytes(), cell.generation, dict(cell.objects)) == before


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


@pytest.mark.parametrize(
    "kind", ["fuel:OpenRobotics/Table", "https://fuel.gazebosim.org/1.0/a/models/b"]
)
def test_a_snapshot_downloads_nothing(parts, monkeypatch, tmp_path, kind):
    monkeypatch.setenv("GZ_FUEL_CACHE_PATH", str(tmp_path))
    monkeypatch.setattr(Session, "get", lambda *_, **__: pytest.fail("the network was used"))
    station = build_station(parts)
    state = station.get_state()
    state["cell"]["entities"][-1] = {**state["cell"]["entities"][-1], "name": "x", "kind": kind}
    with pytest.raises(BtManipError, match="a snapshot downloads no models, and '.*' is not here"):
        station.set_state(state)
