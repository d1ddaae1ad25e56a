"""Start situations: made once, put back exactly, extended by users."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.behaviours import MoveHome
from bt_manip.exceptions import BtManipError
from bt_manip.testing.end_states import assert_stands_still, assert_touches_only, assert_tower
from bt_manip.testing.situations import Situations, built_in_situations, play


def test_a_situation_is_put_back_to_the_last_bit(situations):
    for name in situations.names:
        before = situations.reset(name).cell.state_bytes()
        station = situations.reset(name)
        assert station.cell.state_bytes() == before
        station.arm.move_to_configuration(np.full(7, 0.1) + station.arm.q)
        station.cell.step(20)
        assert situations.reset(name).cell.state_bytes() == before
        assert not station.arm.moving


def test_objects_that_a_test_adds_or_removes_do_not_stay(situations):
    station = situations.reset()
    before = station.cell.state_bytes()
    station.cell.add(station.models.create("cube"), spatial.pose((0.3, -0.2, 1.1)), name="other")
    station.cell.remove("cube")
    situations.reset()
    assert "other" not in station.cell.objects and "cube" in station.cell.objects
    assert station.cell.state_bytes() == before


def test_what_was_compiled_for_a_situation_is_there_after_a_test_that_adds_things(build_station):
    situations = built_in_situations(build_station)  # whose model no other test has changed
    station = situations.reset("holding a cube over the table")
    model, before = station.cell.model, station.cell.state_bytes()
    for y in (-0.2, -0.3):
        station.cell.add(station.models.create("cube"), spatial.pose((0.3, y, 1.1)))
    station.cell.step(10)
    situations.reset("holding a cube over the table")
    assert station.cell.model is model
    assert station.cell.state_bytes() == before
    station.arm.move_to_configuration(np.full(7, 0.1) + station.arm.q)
    station.cell.step(20)
    assert station.gripper.held == ("cube",)


def test_a_situation_is_simulated_once(build_station):
    made = []
    situations = built_in_situations(build_station)
    situations.add("counted", made.append)
    first = situations.reset("counted").cell.time
    assert situations.reset("counted").cell.time == first
    assert len(made) == 1


def test_names_that_are_taken_or_unknown_are_refused(build_station):
    situations = Situations(build_station)
    situations.add("a", print, after=None)
    situations.add("a", print, after=None)  # the same again: a conftest may be read twice
    with pytest.raises(BtManipError, match="already a situation 'a'"):
        situations.add("a", repr, after=None)
    for _ in range(2):  # a fixture of each test
        situations.add("b", lambda station: station.cell.step(1), after="a")
    with pytest.raises(BtManipError, match="no start situation 'at rset'"):
        situations.add("c", print, after="at rset")
    with pytest.raises(BtManipError, match="no start situation 'aa'; did you mean 'a'"):
        situations.reset("aa")


def test_a_situation_that_cannot_be_reached_says_why(station):
    with pytest.raises(AssertionError, match="MoveHome ended with FAILURE: .*speed"):
        play(station, MoveHome(speed=0.0))


def test_end_states_are_read_off_the_physics(situations):
    cell = situations.reset().cell
    assert_tower(cell, ["cube"], on="table")
    with pytest.raises(AssertionError, match="'cube' touches table, expected basket"):
        assert_touches_only(cell, "cube", "basket")
    cell.data.qvel[-6] = 0.02
    with pytest.raises(AssertionError, match="'cube' moves at 20.0 mm/s"):
        assert_stands_still(cell, "cube")


def test_a_tower_that_leans_is_none(situations):
    station = situations.reset()
    cube, at = station.models.create("cube"), station.cell.pose("cube").translation
    station.cell.add(cube, spatial.pose(at + [0.01, 0.0, 0.05]), name="upper")
    station.cell.step(100)
    assert_tower(station.cell, ["cube", "upper"], on="table")
    with pytest.raises(AssertionError, match="'upper' touches"):
        assert_tower(station.cell, ["upper", "cube"], on="table")
