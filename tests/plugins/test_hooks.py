"""Every hook is documented and of one shape."""

import inspect

import pytest

from bt_manip import hookspecs
from bt_manip.registry import Parts

HOOKS = [name for name in vars(hookspecs) if name.startswith("register_")]


def test_there_is_a_hook_for_each_kind_of_part():
    assert {name.removeprefix("register_") for name in HOOKS} == set(Parts().by_kind())


@pytest.mark.parametrize("name", HOOKS)
def test_a_hook_takes_register_and_says_how_to_call_it(name):
    hook = getattr(hookspecs, name)
    assert list(inspect.signature(hook).parameters) == ["register"]
    assert "``register(" in inspect.getdoc(hook)
