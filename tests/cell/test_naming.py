"""Names of entities, bodies and nameless elements."""

import pytest
from dm_control import mjcf

from bt_manip.cell import Cell, Cube, escaped_name, literal_name, short_name, unique_name
from bt_manip.cell.naming import body_name, entity_of, name_elements
from bt_manip.spatial import pose


def test_a_taken_name_gets_the_first_free_number():
    assert unique_name("cube", []) == "cube"
    assert unique_name("cube", ["cube", "cube_2"]) == "cube_1"
    assert unique_name("cube", ["cube", "cube_1"]) == "cube_2"


def test_labels_leave_out_what_only_repeats():
    assert body_name("world") == "world"
    assert body_name("cube/") == "cube"
    assert body_name("cube/cube") == "cube"
    assert body_name("panda/left_finger") == "panda/left_finger"
    assert body_name("panda/gripper/") == "panda/gripper"
    assert entity_of("panda/left_finger") == "panda"


def test_the_only_body_of_a_renamed_entity_goes_by_the_entitys_name():
    cell = Cell()
    cell.add(Cube(), pose((0, 0, 0.024)), name="die")
    cell.step()
    assert cell.contacts.pairs() == [("die", "world")]
    assert cell.body_id("die") == cell.model.body("die/").id


def test_nameless_elements_get_names_that_collide_with_none():
    root = mjcf.from_xml_string("""
        <mujoco><worldbody>
          <geom size="1"/><geom name="geom0" size="1"/><site/>
          <body><freejoint/><geom size="1"/></body>
        </worldbody></mujoco>""")
    name_elements(root)
    names = [geom.name for geom in root.find_all("geom")]
    assert all(names) and len(set(names)) == 3
    assert root.find_all("site")[0].name and root.find_all("body")[0].name


@pytest.mark.parametrize("name", ["link", "left/link", "a/b/c", "back\\slash", "both/and\\"])
def test_the_name_in_a_model_file_is_found_again(name):
    assert "/" not in escaped_name(name)
    assert literal_name(escaped_name(name)) == name
    assert short_name(f"robot/{escaped_name(name)}") == name
    assert body_name(f"robot/{escaped_name(name)}") == f"robot/{name}"
