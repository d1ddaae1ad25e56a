"""bt-manip list: what there is, and whose."""

import pytest


@pytest.mark.parametrize(
    ("kind", "name", "owner"),
    [
        ("trees", "pick_place", "builtin"),
        ("behaviours", "Hover", "builtin"),
        ("behaviours", "Sequence", "tree language"),
        ("objects", "cube", "builtin"),
        ("objects", "push_button", "impedance"),
        ("robots", "panda", "builtin"),
        ("controllers", "joint_impedance", "impedance"),
        ("plugins", "builtin", "0.1.0"),
    ],
)
def test_each_kind_is_listed_with_its_owner(bt_manip, kind, name, owner):
    code, out, err = bt_manip("list", kind)
    assert (code, err) == (0, "")
    (line,) = [line for line in out.splitlines() if line.split()[0] == name]
    assert owner in line


def test_without_a_kind_everything_is_listed(bt_manip):
    out = bt_manip("list").out
    for heading in ("trees:", "behaviours:", "objects:", "robots:", "controllers:", "plugins:"):
        assert heading in out.splitlines()
