"""What is registered as graspable is picked, also where things lie close together."""

import pytest

from bt_manip.plugins import load_plugins

from .conftest import report_of

OBJECTS = load_plugins(entry_points=()).parts.objects
GRASPABLE = [name for name in OBJECTS.names() if OBJECTS.get(name).category == "graspable"]


def all_taken(report) -> bool:
    return all(c.status == "SUCCESS" and c.unexpected_contacts == () for c in report.cycles)


@pytest.mark.soak
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("name", GRASPABLE)
def test_it_is_picked_and_dropped_into_the_basket(parts, name, seed):
    report = report_of(parts, "pick_place", settings={"cube": name}, seed=seed)
    assert all_taken(report) and report.cycles[0].placed


def test_all_three_cubes_are_taken_and_nothing_else_is_touched(parts):
    assert all_taken(report_of(parts, "pick_place_cluttered", seed=3))


@pytest.mark.soak
def test_three_hundred_of_three_hundred_cubes_are_taken(parts):
    report = report_of(parts, "pick_place_cluttered", seed=11, cycles=100)
    assert len(report.cycles) == 100 and all_taken(report)
