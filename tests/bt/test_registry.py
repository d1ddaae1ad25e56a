"""The names that trees know."""

from enum import Enum

import pytest

from bt_manip.bt import Action, BehaviourRegistry
from bt_manip.exceptions import TreeError, UnknownBehaviourError


class Hover(Action):
    """Move the tool over an object.

    More words.
    """


def test_all_nodes_of_the_language_are_in_every_registry():
    names = BehaviourRegistry().names()

    assert len(names) == 42 and "Sequence" in names and "SubTree" in names


def test_a_class_is_known_by_its_name_or_another_one():
    registry = BehaviourRegistry([Hover])
    registry.register(Hover, "Approach")

    assert registry.get("Hover") is registry.get("Approach") is Hover
    assert registry.names(built_in=False) == ["Approach", "Hover"]
    assert registry.get("Hover").summary() == "Move the tool over an object."
    registry.register(Hover)
    with pytest.raises(UnknownBehaviourError, match="no behaviour is named 'Hovr'; did you mean"):
        registry.get("Hovr")


@pytest.mark.parametrize("name", ["Sequence", "Root", "a b", "a/b", "a.b"])
def test_a_name_that_is_taken_or_not_allowed_is_refused(name):
    with pytest.raises(TreeError):
        BehaviourRegistry().register(Hover, name)


def test_what_is_no_node_cannot_be_registered():
    with pytest.raises(TreeError, match="expected a subclass of Action"):
        BehaviourRegistry().register(str)


def test_a_copy_is_ones_own():
    registry = BehaviourRegistry()
    copied = registry.copy()
    copied.register(Hover)
    copied.register_enum("FAST", 3)

    assert "Hover" not in registry and dict(registry.enums) == {}


def test_numbers_are_known_by_name():
    class Colour(Enum):
        RED = 1

    registry = BehaviourRegistry()
    registry.register_enum(Colour)
    registry.register_enum("RED", 1)

    assert dict(registry.enums) == {"RED": 1}
    with pytest.raises(TreeError, match="'RED' is 1 already; it cannot be 2"):
        registry.register_enum("RED", 2)
    with pytest.raises(TreeError, match="integers by name"):
        registry.register_enum("PI", 3.14)
