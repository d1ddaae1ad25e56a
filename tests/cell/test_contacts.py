"""Who touches whom and how hard, against weights computed by hand."""

import numpy as np
import pinocchio as pin
import pytest
from dm_control import composer, mjcf

from bt_manip.cell import Cell, CellError, Cube, Table
from bt_manip.cell.contacts.contact_monitor import ContactMonitor
from bt_manip.cell.naming import BodyNames
from bt_manip.spatial import pose

G = 9.81
SURFACE = 1.015


@pytest.fixture
def cell():
    """A light cube on a heavy one on the table."""
    cell = Cell()
    with cell.editing():
        cell.add(Table())
        cell.add(Cube(mass=2.0), pose((0.1, 0.2, SURFACE + 0.025)), name="heavy")
        cell.add(Cube(mass=0.5), pose((0.1, 0.2, SURFACE + 0.075)), name="light")
    cell.step(500)
    return cell


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


def test_the_wrench_of_a_resting_object_is_its_weight(cell):
    wrench = cell.contacts.wrench("light")
    np.testing.assert_allclose(wrench.force, (0, 0, 0.5 * G), rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(wrench.torque, 0, atol=1e-3)
    both_sides = cell.contacts.wrench("heavy")  # table up, light cube down
    np.testing.assert_allclose(both_sides.force, (0, 0, 2.0 * G), rtol=1e-3, atol=1e-3)


def test_a_wrench_is_given_at_a_point_in_a_frame(cell):
    at_origin = cell.contacts.wrench("light", point=np.zeros(3))
    # r x f with r = (0.1, 0.2, z), f = (0, 0, m g)
    np.testing.assert_allclose(at_origin.torque, (0.2 * 0.5 * G, -0.1 * 0.5 * G, 0), atol=5e-3)
    T_wf = pin.SE3(pin.utils.rotate("x", np.pi / 2), np.array([0.0, 0.2, 0.0]))
    turned = cell.contacts.wrench("light", frame=T_wf)
    np.testing.assert_allclose(turned.force, (0, 0.5 * G, 0), atol=5e-3)
    # About (0, 0.2, 0) the torque is (0, -0.1 m g, 0) in the world: along -z of the turned frame.
    np.testing.assert_allclose(turned.torque, (0, 0, 0.1 * 0.5 * G), atol=5e-3)


def slope(mu, steps):
    """A cube of 1 kg on the floor, gravity turned by 20 degrees."""
    angle = np.radians(20)
    cell = Cell()
    cell.arena.mjcf_model.option.gravity = (G * np.sin(angle), 0, -G * np.cos(angle))
    cell.arena.mjcf_model.find("geom", "floor").friction = (1e-5, 0.005, 0.0001)
    cell.add(Cube(mass=1.0, friction=mu), pose((0, 0, 0.025)))
    cell.step(steps)
    return cell, angle


def test_friction_holds_a_cube_on_a_slope_inside_its_cone():
    cell, angle = slope(0.6, 300)
    force = cell.contacts.between("world", "cube")
    assert force.normal == pytest.approx(G * np.cos(angle), rel=1e-3)
    assert force.friction == pytest.approx(G * np.sin(angle), rel=1e-3)
    np.testing.assert_allclose(force.force, (-G * np.sin(angle), 0, force.normal), atol=1e-3)
    assert np.linalg.norm(cell.velocity("cube")) < 1e-3


def test_a_cube_slides_where_the_slope_leaves_the_cone():
    cell, angle = slope(0.3, 50)
    force = cell.contacts.between("world", "cube")
    assert force.friction == pytest.approx(0.3 * force.normal, rel=1e-3)
    expected = (np.sin(angle) - 0.3 * np.cos(angle)) * G * 0.05
    assert cell.velocity("cube")[0] == pytest.approx(expected, rel=0.1)


def test_nothing_touches_in_the_air():
    cell = Cell()
    cell.add(Cube(), pose((0, 0, 3)))
    cell.step(3)
    assert cell.contacts.pairs() == []
    assert not cell.contacts.touching("cube")
    np.testing.assert_array_equal(cell.contacts.wrench("cube").force, 0)


def test_penetration_is_the_deepest_overlap():
    cell = Cell()
    cell.add(Cube(), pose((0, 0, 0.024)))
    cell.step()
    assert cell.contacts.penetration("cube", "world") == pytest.approx(0.001, abs=1e-4)
    assert cell.contacts.penetration("world", "cube") == cell.contacts.penetration("cube", "world")


def test_an_unknown_body_offers_the_nearest(cell):
    with pytest.raises(CellError, match="did you mean 'heavy'"):
        cell.contacts.wrench("heavi")


class Claw(composer.Entity):
    """A fixed post with a finger beside it."""

    def _build(self):
        self.root = mjcf.from_xml_string("""
            <mujoco model="claw"><worldbody>
              <body name="post" pos="0 0 0.2">
                <geom size="0.05" mass="1"/>
                <body name="finger" pos="0.2 0 0"><geom size="0.05" mass="1"/></body>
              </body>
            </worldbody></mujoco>""")

    @property
    def mjcf_model(self):
        return self.root

    @property
    def contact_bodies(self):
        return [self.root.find("body", "finger")]


def test_fingers_may_touch_and_the_rest_of_a_robot_may_not():
    cell = Cell()
    cell.add(Claw())
    cell.add(Cube(), pose((0.2, 0, 0.274)))  # rests on the finger
    cell.step()
    assert cell.contact_monitor.summary() == ((), ("cube",), True)
    cell.add(Cube(), pose((0, 0, 0.274)))  # rests on the post
    cell.step()
    assert cell.contact_monitor.summary().unexpected == (("claw/post", "cube_1"),)
    assert cell.contact_monitor.summary().held == ("cube",)


def test_a_held_thing_that_meets_another_is_not_free():
    cell = Cell()
    cell.add(Claw())
    cell.add(Cube(), pose((0.2, 0, 0.274)))
    cell.add(Cube(), pose((0.2, 0, 0.3235)))
    cell.step(2)
    assert cell.contact_monitor.summary() == ((), ("cube",), False)


def test_things_that_are_not_robots_touch_each_other_as_they_like(cell):
    assert cell.contact_monitor.summary() == ((), (), True)


def test_every_step_is_judged_by_its_own_contacts_as_they_come_and_go():
    cell = Cell()
    with cell.editing():
        cell.add(Claw())
        cell.add(Cube(), pose((0.21, 0.01, 0.35), (0.9, 0.4, 0.3, 0.2)))  # tumbles off the finger
        cell.add(Cube(), pose((0.0, 0.02, 0.33), (0.9, 0.1, 0.5, 0.0)))  # and this one off the post
    judged = set()
    for _ in range(800):
        cell.step()
        anew = ContactMonitor(cell.data, BodyNames(cell.model), {"claw": ["claw/finger"]})
        assert cell.contact_monitor.summary() == anew.summary()
        judged.add(cell.data.contact.geom.tobytes())
    assert len(judged) > 5
