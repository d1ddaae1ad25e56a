"""bt-manip list: what there is, and whose."""

from pathlib import Path

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
        ("scenes", "two_arms", "builtin"),
        ("controllers", "joint_impedance", "impedance"),
        ("plugins", "builtin", "0.1.0"),
    ],
)
def test_each_kind_is_listed_with_its_owner(bt_manip, kind, name, owner):
    code, out, err = bt_manip("list", kind)
    assert (code, err) == (0, "")
    (line,) = [line for line in out.splitlines() if line.split()[0] == name]
    assert owner in line
    assert bt_manip("list", kind, name).out.startswith(f"{name} ({owner})")


def test_without_a_kind_everything_is_listed(bt_manip):
    out = bt_manip("list").out
    for heading in ("trees:", "behaviours:", "objects:", "robots:", "controllers:", "plugins:"):
        assert heading in out.splitlines()


def test_one_behaviour_is_shown_with_its_ports(bt_manip):
    code, out, err = bt_manip("list", "behaviours", "Grasp")
    assert (code, err) == (0, "")
    assert bt_manip("list", "Grasp").out == out
    first, *rest = out.splitlines()
    assert first == "Grasp (builtin)"
    assert any(line.startswith("  force (input, double, at least 0, default ") for line in rest)


def test_parts_of_one_name_are_told_apart_by_their_kinds(bt_manip):
    out = bt_manip("list", "two_arms").out.splitlines()
    assert [line for line in out if line in ("trees:", "scenes:")] == ["trees:", "scenes:"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("behaviours", "Graps"), "there is no 'Graps'; did you mean 'Grasp'"),
        (("Hovr",), "there is no kind or part 'Hovr'; did you mean 'Hover'"),
        (("behaviors", "Hover"), "there is no kind 'behaviors'; did you mean 'behaviours'"),
        (("scenes", "--robot", "panda"), "bt-manip list tasks"),
    ],
)
def test_what_is_neither_a_kind_nor_a_part_is_bad_input(bt_manip, words, message):
    code, _, err = bt_manip("list", *words)
    assert code == 2
    assert message in err


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("objects shelf", "boards (whole number from 2 to 100, default 3): Number of boards, top"),
        ("objects shelf", "size (3 positive numbers, default 0.25, 0.6, 0.7): Outer lengths along"),
        ("objects cube", "mass (number above 0 and at most 1e+10): Mass; by default that of its"),
        ("faults push", "force (number of at least 0, default 100): Force [N]."),
        ("behaviours MoveHome", "speed (input, double, above 0 and at most 1, default 1.0): Frac"),
        ("behaviours MoveHome", "wait (input, double, at least 0, default 10.0): Timeout for"),
    ],
)
def test_parameters_are_listed_with_type_bounds_default_and_unit(bt_manip, words, line):
    assert f"\n  {line}" in bt_manip("list", *words.split()).out


def test_ports_fit_the_terminal(bt_manip, screen, monkeypatch):
    read = screen()
    monkeypatch.setenv("COLUMNS", "80")
    assert bt_manip("list", "behaviours", "MoveHome").code == 0
    ports = read().partition("  robot (input")[2].splitlines()
    assert any(line.startswith("    ") for line in ports)
    assert all(len(line) <= 80 for line in ports)


def test_tasks_are_listed_with_the_robots_that_can_do_them(bt_manip):
    code, out, err = bt_manip("list", "tasks", "press_button", "--robot", "panda")
    *levels, last = out.splitlines()
    assert (code, err, last.split()) == (0, "", ["press_button", "panda", "yes"])
    assert levels[0].startswith("in scene press_button by itself: button position plus")
    assert "  scene.mass=2         * mass times 0.5 to 2" in levels
    drawn = bt_manip("list", "tasks", "pick_place", "--robot", "panda").out
    assert "  SpawnObject::2 draws pose\n" in drawn


def test_a_named_robot_whose_model_is_missing_is_one_error_not_one_for_each_task(
    bt_manip, tmp_path
):
    file = tmp_path / "arm.toml"
    rail = Path(__file__).parents[1] / "robots" / "models" / "rail.toml"
    file.write_text(rail.read_text())  # away from its model
    code, out, err = bt_manip("list", "tasks", "--robot", file)
    assert (code, out, len(err.splitlines())) == (2, "", 1) and str(tmp_path) in err
