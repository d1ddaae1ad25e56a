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


def test_one_behaviour_is_shown_with_its_ports(bt_manip):
    code, out, err = bt_manip("list", "behaviours", "Grasp")
    assert (code, err) == (0, "")
    first, *rest = out.splitlines()
    assert first == "Grasp (builtin)"
    assert any(line.startswith("  force (input, double, default ") for line in rest)


@pytest.mark.parametrize("kind", ["objects", "robots", "scenes", "plugins", "trees"])
def test_any_part_is_shown_by_its_name(bt_manip, kind):
    name = bt_manip("list", kind).out.split()[0]
    code, out, _ = bt_manip("list", kind, name)
    assert code == 0
    assert out.startswith(f"{name} (")


def test_an_unknown_part_is_bad_input_with_the_nearest_name(bt_manip):
    code, _, err = bt_manip("list", "behaviours", "Graps")
    assert code == 2
    assert "there is no 'Graps'; did you mean 'Grasp'" in err


def test_a_name_alone_is_enough(bt_manip):
    assert bt_manip("list", "Hover") == bt_manip("list", "behaviours", "Hover")


def test_parts_of_one_name_are_told_apart_by_their_kinds(bt_manip):
    out = bt_manip("list", "two_arms").out.splitlines()
    assert [line for line in out if line in ("trees:", "scenes:")] == ["trees:", "scenes:"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("Hovr",), "there is no kind or part 'Hovr'; did you mean 'Hover'"),
        (("behaviors", "Hover"), "there is no kind 'behaviors'; did you mean 'behaviours'"),
    ],
)
def test_what_is_neither_a_kind_nor_a_part_is_bad_input(bt_manip, words, message):
    code, _, err = bt_manip("list", *words)
    assert code == 2
    assert message in err


def test_the_parameters_of_an_object_are_listed_with_their_defaults(bt_manip):
    out = bt_manip("list", "objects", "shelf").out
    assert "  boards (whole number from 2 to 100, default 3): Number of boards, top and" in out
    assert "  size (3 positive numbers, default 0.25, 0.6, 0.7): Outer lengths along x" in out
    assert (
        "  mass (number above 0 and at most 1e+10, default 6): Mass; it counts where the object is"
        in out
    )
    out = bt_manip("list", "objects", "cube").out
    assert (
        "  mass (number above 0 and at most 1e+10): Mass; by default that of its model [kg]\n"
        in out
    )


def test_the_parameters_of_a_fault_are_listed_with_bounds_and_unit(bt_manip):
    out = bt_manip("list", "faults", "push").out
    assert "  force (number of at least 0, default 100): Force [N].\n" in out


def test_the_ports_of_a_behaviour_are_listed_with_bounds_and_unit(bt_manip):
    out = bt_manip("list", "behaviours", "MoveHome").out
    assert "  speed (input, double, above 0 and at most 1, default 1.0): Fraction of the arm" in out
    assert "  wait (input, double, at least 0, default 10.0): Timeout for another robot" in out


def test_ports_fit_the_terminal(terminal):
    listing = terminal("list", "behaviours", "MoveHome", COLUMNS="80")
    assert listing.end() == 0
    ports = listing.shown.decode().partition("  robot (input")[2].splitlines()
    assert any(line.startswith("    ") for line in ports)
    assert all(len(line) <= 80 for line in ports)


def test_tasks_are_listed_with_the_robots_that_can_do_them(bt_manip):
    code, out, err = bt_manip("list", "tasks", "press_button", "--robot", "panda")
    *levels, last = out.splitlines()
    assert (code, err, last.split()) == (0, "", ["press_button", "panda", "yes"])
    assert levels[0].startswith("in scene press_button by itself: button position plus")
    assert "  scene.mass=2         * mass times 0.5 to 2" in levels


def test_a_task_is_listed_with_what_its_nodes_draw(bt_manip):
    out = bt_manip("list", "tasks", "pick_place", "--robot", "panda").out
    assert "  SpawnObject::2 draws pose\n" in out


def test_a_robot_is_for_the_list_of_tasks_only(bt_manip):
    code, _, err = bt_manip("list", "scenes", "--robot", "panda")
    assert code == 2
    assert "bt-manip list tasks" in err
