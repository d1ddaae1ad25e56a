"""Contacts that begin and end are told once each, when they do."""

import numpy as np
import pytest

from bt_manip.cell import Cell, Cube
from bt_manip.spatial import pose

G = 9.81


@pytest.fixture
def cell():
    """A cube 20 mm over the floor."""
    cell = Cell()
    cell.add(Cube(), pose((0, 0, 0.045)))
    return cell


@pytest.fixture
def events():
    return []


def test_a_fall_begins_a_contact_when_physics_says_so_and_who_listens_changes_nothing(cell, events):
    silent = Cell()
    silent.add(Cube(), pose((0, 0, 0.045)))
    cell.contact_changed.append(events.append)
    for one in (cell, silent):
        one.step(400)
    first = events[0]
    assert (first.first, first.second, first.begins) == ("cube", "world", True)
    assert first.time == pytest.approx(np.sqrt(2 * 0.02 / G), abs=2e-3)  # s = g t^2 / 2
    assert [event.begins for event in events] == [i % 2 == 0 for i in range(len(events))]
    assert events[-1].begins and cell.contacts.pairs() == [("cube", "world")]
    assert cell.state_bytes() == silent.state_bytes()
    cell.contact_changed.clear()
    cell.step(1)


def test_what_touches_already_is_no_event_and_lifting_it_is_one(cell, events):
    cell.step(400)
    cell.contact_changed.append(events.append)
    cell.step(10)
    assert events == []
    cell.data.qvel[2] = 1.0
    cell.step(10)
    assert [(e.first, e.second, e.begins) for e in events] == [("cube", "world", False)]


def test_taking_a_thing_out_ends_its_contacts_even_when_another_takes_its_place(cell, events):
    cell.step(400)
    cell.contact_changed.append(events.append)
    cell.step(1)
    with cell.editing():
        cell.remove("cube")
        cell.add(Cube(), pose((0, 0, 0.0249)), name="die")
    cell.step(1)
    assert [(e.first, e.second, e.begins) for e in events] == [
        ("cube", "world", False),
        ("die", "world", True),
    ]


def test_after_a_restore_a_step_is_compared_with_the_restored_contacts(cell, events):
    falling = cell.snapshot()
    cell.step(400)
    resting = cell.snapshot()
    cell.contact_changed.append(events.append)
    cell.step(1)
    cell.restore(falling)
    cell.step(1)
    cell.restore(resting)
    cell.step(1)
    assert events == []
