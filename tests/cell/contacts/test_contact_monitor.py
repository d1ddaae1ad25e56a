"""Contacts are classified: expected or not, held, and free of everything else."""

from dm_control import composer, mjcf

from bt_manip.cell import BodyNames, Cell, Cube, MonitoredEntity
from bt_manip.cell.contacts.contact_monitor import ContactMonitor
from bt_manip.spatial import pose


class Claw(MonitoredEntity, composer.ModelWrapperEntity):
    """A fixed post with a finger beside it."""

    contact_bodies = property(lambda self: [self.mjcf_model.find("body", "finger")])


def claw() -> Claw:
    return Claw(
        mjcf.from_xml_string("""
            <mujoco model="claw"><worldbody>
              <body name="post" pos="0 0 0.2">
                <geom size="0.05" mass="1"/>
                <body name="finger" pos="0.2 0 0"><geom size="0.05" mass="1"/></body>
              </body>
            </worldbody></mujoco>""")
    )


def test_what_contact_bodies_touch_is_held_and_free_of_other_things_and_the_rest_is_unexpected():
    cell = Cell()
    cell.add(claw())
    cell.add(Cube(), pose((0.2, 0, 0.274)))  # rests on the finger
    cell.step()
    assert cell.contact_monitor.summary() == ((), ("cube",), True)
    cell.add(Cube(), pose((0.2, 0, 0.3235)), name="upper")
    cell.step()
    assert cell.contact_monitor.summary() == ((), ("cube",), False)
    cell.add(Cube(), pose((0, 0, 0.274)))  # rests on the post
    cell.step()
    assert cell.contact_monitor.summary().unexpected == (("claw/post", "cube_1"),)
    assert cell.contact_monitor.summary().held == ("cube",)


def test_no_body_of_a_robot_may_touch_another_robot():
    cell = Cell()
    cell.add(claw())
    cell.add(claw(), pose((0.2, -0.2, 0.099), (0.5**0.5, 0, 0, 0.5**0.5)), free=True)
    cell.step()  # a finger rests on the other
    assert cell.contact_monitor.summary() == ((("claw/finger", "claw_1/finger"),), (), True)


def test_contacts_between_objects_are_expected(cell):
    assert cell.contact_monitor.summary() == ((), (), True)


def test_every_summary_is_of_the_contacts_of_its_own_step():
    cell = Cell()
    with cell.editing():
        cell.add(claw())
        cell.add(Cube(), pose((0.21, 0.01, 0.35), (0.9, 0.4, 0.3, 0.2)))  # tumbles off the finger
        cell.add(Cube(), pose((0.0, 0.02, 0.33), (0.9, 0.1, 0.5, 0.0)))  # and this one off the post
    judged = set()
    for _ in range(800):
        cell.step()
        anew = ContactMonitor(cell.data, BodyNames(cell.model), cell.entities.values())
        assert cell.contact_monitor.summary() == anew.summary()
        judged.add(cell.data.contact.geom.tobytes())
    assert len(judged) > 5
