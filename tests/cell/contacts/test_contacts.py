"""Contacts, their forces and events, against weights and the forces that MuJoCo applies."""

import mujoco
import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip.cell import Cell, CellError, Cube
from bt_manip.spatial import pose
from tests.cell.conftest import SURFACE

G = 9.81


def test_pairs_are_named_by_entity_and_come_once(cell):
    assert cell.contacts.pairs() == [("heavy", "light"), ("heavy", "table")]
    assert cell.contacts.touching("heavy")
    assert cell.contacts.touching("light", "heavy")
    assert not cell.contacts.touching("light", "table")
    assert cell.contacts.partners("heavy") == ["light", "table"]


def test_the_normal_force_is_the_weight_above(cell):
    force = cell.contacts.between("table", "heavy")
    assert force.normal == pytest.approx(2.5 * G, rel=1e-3)
    np.testing.assert_allclose(force.force, (0, 0, 2.5 * G), atol=0.03)
    assert cell.contacts.between("heavy", "table").force[2] == pytest.approx(-2.5 * G, rel=1e-3)
    assert cell.contacts.between("light", "table").normal == 0


def test_friction_holds_a_cube_on_a_slope_inside_its_cone():
    angle, cell = np.radians(20), Cell()
    cell.arena.mjcf_model.option.gravity = (G * np.sin(angle), 0, -G * np.cos(angle))
    cell.arena.mjcf_model.find("geom", "floor").friction = (1e-5, 0.005, 0.0001)
    cell.add(Cube(mass=1.0, friction=0.6), pose((0, 0, 0.025)))
    cell.step(300)
    force = cell.contacts.between("world", "cube")
    assert force.normal == pytest.approx(G * np.cos(angle), rel=1e-3)
    assert force.friction == pytest.approx(G * np.sin(angle), rel=1e-3)
    np.testing.assert_allclose(force.force, (-G * np.sin(angle), 0, force.normal), atol=1e-3)
    assert np.linalg.norm(cell.velocity("cube")) < 1e-3


def test_an_unknown_body_offers_the_nearest(cell):
    with pytest.raises(CellError, match="did you mean 'heavy'"):
        cell.contacts.wrench("heavi")


def test_contact_points_are_at_the_corners_and_push_towards_the_body(cell):
    points = cell.contacts.points("heavy")
    for other, height, towards, weight in (("table", 0.0, 1, 2.5), ("light", 0.05, -1, 0.5)):
        found = [point for point in points if point.other == other]
        assert sum(point.force for point in found) == pytest.approx(weight * G, rel=1e-3)
        corners = {tuple(np.round(point.position, 3) + 0.0) for point in found}
        z = pytest.approx(SURFACE + height, abs=1e-3)
        assert sorted(corners) == [(x, y, z) for x in (0.075, 0.125) for y in (0.175, 0.225)]
        for point in found:
            assert point.normal == pytest.approx([0.0, 0.0, towards], abs=1e-6)
    np.testing.assert_allclose(cell.contacts.wrench("heavy").force[2], 2.0 * G, rtol=1e-3)


@pytest.mark.parametrize("condim", [3, 6])
def test_force_and_torque_on_a_spinning_cube_are_those_of_mujoco(condim):
    cell = Cell()
    cell.add(Cube(mass=0.5), pose((0.3, 0.2, 0.025)), name="box")
    geoms = cell.contacts.geoms("box")
    cell.model.geom_condim[geoms] = condim
    cell.model.geom_friction[geoms] = (0.8, 0.02, 0.01)
    cell.step(20)
    cell.data.qvel[:6] = (0.3, -0.2, 0.0, 0.4, 0.3, 6.0)
    cell.step(1)
    assert cell.contacts.touching("box")
    data, body = cell.data, cell.model.dof_bodyid[0]
    mujoco.mj_forward(cell.model, cell.data)
    expected = data.qfrc_constraint[:6].copy()
    torque = data.xmat[body].reshape(3, 3) @ expected[3:]  # it is given in the body's axes
    wrench = cell.contacts.wrench("box", point=data.xpos[body])
    assert wrench.force == pytest.approx(expected[:3], rel=1e-6, abs=1e-9)
    assert wrench.torque == pytest.approx(torque, rel=1e-6, abs=1e-9)
    assert abs(torque[2]) > 1e-4
    point = np.array([1.0, -2.0, 0.5])  # about another point: the force has a lever
    moved = torque + np.cross(data.xpos[body] - point, expected[:3])
    assert cell.contacts.wrench("box", point=point).torque == pytest.approx(
        moved, rel=1e-6, abs=1e-9
    )


def test_the_torque_of_an_entity_is_about_the_origin_of_its_root():
    root = mjcf.RootElement(model="lever")
    body = root.worldbody.add("body", pos=(0.3, 0, 0))
    body.add("geom", type="box", size=(0.05, 0.05, 0.05), mass=1.0)
    cell = Cell()
    cell.add(composer.ModelWrapperEntity(root), pose((0.2, 0.1, 0.05)), name="lever", free=True)
    cell.step(100)
    wrench = cell.contacts.wrench("lever")
    assert wrench.force == pytest.approx([0.0, 0.0, G], rel=1e-3, abs=1e-3)
    assert wrench.torque == pytest.approx([0.0, -0.3 * G, 0.0], rel=1e-2, abs=1e-2)


@pytest.fixture
def dropped():
    """Give a cube 20 mm over the floor."""
    cell = Cell()
    cell.add(Cube(), pose((0, 0, 0.045)))
    return cell


@pytest.fixture
def events():
    return []


def test_a_fall_begins_a_contact_when_physics_says_so_and_who_listens_changes_nothing(
    dropped, events
):
    silent = Cell()
    silent.add(Cube(), pose((0, 0, 0.045)))
    dropped.contact_changed.append(events.append)
    for one in (dropped, silent):
        one.step(400)
    first = events[0]
    assert (first.first, first.second, first.begins) == ("cube", "world", True)
    assert first.time == pytest.approx(np.sqrt(2 * 0.02 / G), abs=2e-3)  # s = g t^2 / 2
    assert [event.begins for event in events] == [i % 2 == 0 for i in range(len(events))]
    assert events[-1].begins and dropped.contacts.pairs() == [("cube", "world")]
    assert dropped.state_bytes() == silent.state_bytes()
    dropped.contact_changed.clear()
    dropped.step(1)


def test_what_touches_already_is_no_event_and_lifting_it_is_one(dropped, events):
    dropped.step(400)
    dropped.contact_changed.append(events.append)
    dropped.step(10)
    assert events == []
    dropped.data.qvel[2] = 1.0
    dropped.step(10)
    assert [(e.first, e.second, e.begins) for e in events] == [("cube", "world", False)]


def test_taking_a_thing_out_ends_its_contacts_even_when_another_takes_its_place(dropped, events):
    dropped.step(400)
    dropped.contact_changed.append(events.append)
    dropped.step(1)
    with dropped.editing():
        dropped.remove("cube")
        dropped.add(Cube(), pose((0, 0, 0.0249)), name="die")
    dropped.step(1)
    assert [(e.first, e.second, e.begins) for e in events] == [
        ("cube", "world", False),
        ("die", "world", True),
    ]


def test_after_a_restore_a_step_is_compared_with_the_restored_contacts(dropped, events):
    falling = dropped.snapshot()
    dropped.step(400)
    resting = dropped.snapshot()
    dropped.contact_changed.append(events.append)
    dropped.step(1)
    dropped.restore(falling)
    dropped.step(1)
    dropped.restore(resting)
    dropped.step(1)
    assert events == []
