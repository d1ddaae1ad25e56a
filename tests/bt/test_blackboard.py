"""Scopes, remaps and types of the blackboard."""

import pytest

from bt_manip.bt import Blackboard
from bt_manip.bt.blackboard import EMPTY
from bt_manip.bt.port_types import BOOL, DOUBLE, INT, INT64, STRING, UNTYPED
from bt_manip.exceptions import BlackboardError


def test_an_entry_that_was_not_written_is_none():
    scope = Blackboard()
    scope.declare("x", INT)
    scope["target"] = 1

    assert scope.entry("x").value is EMPTY and "x" not in scope and scope.get("y", 7) == 7
    with pytest.raises(BlackboardError, match="never written"):
        scope["x"]
    with pytest.raises(BlackboardError, match="no entry 'targte'; did you mean 'target'"):
        scope["targte"]


def test_the_first_write_declares_the_type_but_a_string_leaves_it_open():
    scope = Blackboard()
    scope.write("i", 1, INT)
    scope.write("s", "a", STRING)

    assert scope.entry("i").declared is INT
    assert scope.entry("s").declared is UNTYPED


@pytest.mark.parametrize(
    ("declared", "first", "second", "type", "kept"),
    [
        (INT, 1, "12", STRING, 12),
        (DOUBLE, 1.0, 3, INT, 3.0),
        (INT, 1, True, BOOL, 1),
        (INT, 1, 2.0, DOUBLE, 2),
    ],
)
def test_a_later_write_is_cast_to_the_declared_type(declared, first, second, type, kept):
    scope = Blackboard()
    scope.write("x", first, declared)
    scope.write("x", second, type)

    assert scope["x"] == kept and isinstance(scope["x"], declared.python)


@pytest.mark.parametrize(
    ("declared", "first", "second", "type"),
    [
        (INT, 1, 2.5, DOUBLE),
        (INT, 1, 1 << 40, INT64),
        (INT, 1, "abc", STRING),
        (BOOL, True, 1, INT),
        (DOUBLE, 1.0, (1 << 60) + 1, INT64),
    ],
)
def test_a_write_that_would_lose_something_is_refused(declared, first, second, type):
    scope = Blackboard()
    scope.write("x", first, declared)

    with pytest.raises(BlackboardError, match="entry 'x' does not take"):
        scope.write("x", second, type)
    assert scope["x"] == first


def test_a_type_cannot_change_once_it_is_declared():
    scope = Blackboard()
    scope.declare("x", INT)

    with pytest.raises(BlackboardError, match="holds int; it cannot become double"):
        scope.declare("x", DOUBLE)


class TestScopes:
    """A sub-tree sees only what is handed to it; the engine's traces have remaps in many ways."""

    @pytest.fixture
    def outer(self):
        outer = Blackboard()
        outer["x"] = 1
        return outer

    def test_the_place_of_a_key_is_known_before_it_is_written(self, outer):
        inner = Blackboard(outer)
        inner.remap("p", "new")
        inner.remap("p", "later")  # the first one counts
        assert inner.place("p") == (outer, "new")
        assert inner.place("@p") == (outer, "p")
        assert inner.place("other") == (inner, "other")
        inner.autoremap = True
        assert inner.place("other") == (outer, "other")
        assert inner.place("_own") == (inner, "_own")

    def test_an_at_sign_always_means_the_root(self, outer):
        inner = Blackboard(Blackboard(outer))
        inner["@x"] = 9

        assert outer["x"] == 9 and inner["@x"] == 9
        with pytest.raises(BlackboardError, match="more than once"):
            inner.declare("@@x")

    def test_unset_removes_only_the_own_entry(self, outer):
        inner = Blackboard(outer)
        inner.remap("p", "x")
        inner.unset("p")
        outer.unset("x")

        assert "x" not in outer and inner.entry("p") is None


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5", 5),
        ("2.5", 2.5),
        ("1e3", 1000.0),
        ("true", "true"),
        ("", ""),
        ("+1", "+1"),
        ("99999999999999999999", 1e20),
    ],
)
def test_a_constant_given_as_text_is_a_number_if_all_of_it_is(text, value):
    scope = Blackboard()
    scope.set_text("c", text)

    assert scope["c"] == value and type(scope["c"]) is type(value)
