"""Objects made of models of Fuel: in a cell, in a tree, in a scene, in a state."""

import json

import numpy as np
import pytest
from requests import Session

from bt_manip import build_station, spatial
from bt_manip.behaviours import Grasp, Hover, Reach, SpawnObject
from bt_manip.bt import Sequence
from bt_manip.exceptions import BtManipError
from bt_manip.runner import prepare, request_of

from .fuel_server import bundled_sdf, model_zip


def prepared(parts, table):
    """Prepare a run with another table; nothing is warned of."""
    return prepare(request_of("pick_place", parts, settings={"table": table}), parts, pytest.fail)


def test_a_table_of_another_height_or_origin_takes_the_robot_and_the_basket_along(server, parts):
    # 15 mm of the top's half thickness become 165 mm: its surface comes to 1.165 m.
    thick = bundled_sdf("table", static=True).replace("1.5 0.8 0.03", "1.5 0.8 0.33")
    server.add("someone", "thick", model_zip(thick))
    run = prepared(parts, "fuel:someone/thick")
    assert run.station.cell.pose("basket").translation[2] == pytest.approx(1.165, abs=1e-9)
    run.execute([])
    assert run.goal.holds
    server.add("someone", "raised", model_zip(bundled_sdf("table", static=True, raised=-0.3)))
    cell = prepared(parts, "fuel:someone/raised").station.cell
    assert cell.pose("table").translation[2] == pytest.approx(0.3, abs=1e-9)
    assert cell.pose("basket").translation[2] == pytest.approx(1.015, abs=1e-9)


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
