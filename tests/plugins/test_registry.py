"""Registries hand out copies and offer the nearest names."""

import pytest

from bt_manip.registry import Registry, UnknownPartError


@pytest.fixture
def robots() -> Registry[dict]:
    registry: Registry[dict] = Registry("robot")
    registry.add("panda", {"home": [0.0, 1.0]}, "builtin")
    registry.add("ur5e", {"home": [2.0]}, "arms")
    return registry


def test_what_comes_out_is_a_copy(robots):
    robots.get("panda")["home"].append(3.0)
    assert robots.get("panda") == {"home": [0.0, 1.0]}


def test_a_mistyped_name_gets_the_nearest_one(robots):
    with pytest.raises(UnknownPartError) as caught:
        robots.get("pand")
    assert str(caught.value) == "unknown robot 'pand'; did you mean 'panda'?"
    assert caught.value.known == ("panda", "ur5e")


def test_a_name_far_from_all_gets_all(robots):
    with pytest.raises(UnknownPartError, match="known: panda, ur5e"):
        robots.owner("zebra")
