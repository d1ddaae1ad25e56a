"""Bad input: exit 2, one clear message, no traceback, nothing simulated, nothing written."""

import gc
import os
import textwrap
from pathlib import Path

import pytest

from bt_manip.runner.run import Run

XML = """
    <root BTCPP_format="4" main_tree_to_execute="Main">
      <BehaviorTree ID="Main">
        {}
      </BehaviorTree>
    </root>
"""


@pytest.fixture
def refused(bt_manip, trees, tmp_path, monkeypatch):
    """Run what must be refused; give the message."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Run, "execute", lambda *_, **__: pytest.fail("it was simulated"))
    report = tmp_path / "report.json"

    def refuse(*arguments: object, report_path: Path = report) -> str:
        code, out, err = bt_manip("run", *arguments, "--report", report_path)
        assert code == 2, err
        assert out == ""
        assert "Traceback" not in err
        assert sum("Error" in line for line in err.splitlines()) == 1
        assert not report.exists()
        return err

    return refuse


def xml(tmp_path: Path, body: str) -> Path:
    path = tmp_path / "task.xml"
    path.write_text(textwrap.dedent(XML).strip().format(body))
    return path


def test_the_garbage_collector_is_on_again_after_bad_input(refused):
    refused("no_such_tree")
    assert gc.isenabled()


def test_an_unknown_tree(refused):
    assert "unknown tree 'pick_plce'; did you mean 'pick_place' or " in refused("pick_plce")


def test_a_goal_that_names_no_condition(refused, tmp_path):
    path = xml(tmp_path, "<AlwaysSuccess/>")
    text = path.read_text()
    path.write_text(text.replace('ID="Main"', 'ID="Main" _goal="IsInn object=a container=b"'))
    assert "task.xml:2:34: error: _goal: no condition is named 'IsInn'; did you mean" in refused(
        path
    )


def test_a_goal_that_does_not_say_for_which_of_two_robots(refused, tmp_path):
    path = xml(tmp_path, "<AlwaysSuccess/>")
    path.write_text(path.read_text().replace('ID="Main"', 'ID="Main" _goal="IsHolding object=a"'))
    error = refused(path, "--scene", "two_arms")
    assert "goal/IsHolding: " in error and "select one by the port robot" in error


def test_a_tree_file_that_is_not_there(refused, tmp_path):
    (tmp_path / "task.xml").touch()
    assert "did you mean 'task.xml'" in refused("tsk.xml")
    assert "no folder" in refused("nowhere/task.xml")


@pytest.mark.parametrize("name", ["task.xml", "task.py"])
def test_a_folder_that_is_called_like_a_tree(refused, tmp_path, name):
    (tmp_path / name).mkdir()
    function = ":make" if name.endswith(".py") else ""
    assert f"'{name}' is a folder; a tree is a file" in refused(name + function)


def test_a_python_file_without_a_function(refused, trees):
    assert "write 'small_trees.py:NAME'" in refused("small_trees.py")
    assert "did you mean 'quick'" in refused("small_trees.py:quik")
    assert "did you mean 'small_trees.py'" in refused("smal_trees.py:quick")


def test_a_module_that_is_not_there(refused):
    assert "no_such_module_anywhere" in refused("no_such_module_anywhere:tree")


def test_a_python_tree_that_raises(refused):
    message = refused("small_trees.py:broken")
    assert "RuntimeError" in message and "no tree today" in message
    assert "small_trees.py:" in message


def test_a_python_function_that_gives_no_tree(refused):
    assert "int" in refused("small_trees.py:no_tree")


def test_malformed_xml_is_named_by_line_and_column(refused, tmp_path):
    path = xml(tmp_path, "<Sequence>\n<AlwaysSuccess>\n</Sequence>")
    assert f"{path.name}:5:" in refused(path)


def test_an_unknown_behaviour(refused, tmp_path):
    message = refused(xml(tmp_path, '<Hovr object="cube"/>'))
    assert "did you mean 'Hover'" in message
    assert "task.xml:3:" in message


def test_an_unknown_port(refused, tmp_path):
    message = refused(xml(tmp_path, '<Hover object="cube" heigt="0.3"/>'))
    assert "did you mean 'height'" in message
    assert "task.xml:3:" in message


def test_a_port_value_of_the_wrong_type(refused, tmp_path):
    message = refused(xml(tmp_path, '<Hover object="cube" height="tall"/>'))
    assert "height" in message and "tall" in message
    assert "task.xml:3:" in message


def test_an_unknown_robot(refused, trees):
    assert "unknown robot 'pnda'; did you mean 'panda'?" in refused(
        "small_trees.py:quick", "--robot", "pnda"
    )


def test_an_unknown_controller(refused, trees):
    assert "did you mean 'computed_torque'" in refused(
        "small_trees.py:quick", "--controller", "computed_torqe"
    )


def test_an_unknown_object(refused, tmp_path):
    message = refused(xml(tmp_path, '<SpawnObject model="cub" object="{o}"/>'))
    assert "did you mean 'cube'" in message


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ('<Hover object="cub"/>', "port 'object' of Hover: no object 'cub'; known: basket, "),
        ('<Drop container="bskt"/>', "port 'container' of Drop: no object 'bskt'; did you mean"),
        ('<IsIn object="part_*" container="basket"/>', "no object is called 'part_*'; there are "),
        ('<IsIn object="kind:can" container="basket"/>', "table (table), basket (basket)"),
    ],
)
def test_an_object_that_the_scene_lacks_is_placed_at_its_line(
    refused, bt_manip, tmp_path, node, message
):
    path = xml(tmp_path, node)
    error = refused(path)
    assert message in error and "task.xml:3:" in error
    code, _, err = bt_manip("evaluate", path, "--episodes", 2)
    assert code == 2 and message in err and "task.xml:3:" in err


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ('<SubTree ID="To" to="bskt"/>', "port 'container' of Drop: no object 'bskt'; did you"),
        (
            '<Sequence><Script code="to := \'bskt\'"/><Drop container="{to}"/></Sequence>',
            "port 'container' of Drop: no object 'bskt'; did you mean 'basket'?",
        ),
        ('<SubTree ID="Go" to="hom"/>', "no configuration is named 'hom'; did you mean 'home'?"),
    ],
)
def test_a_name_that_an_entry_holds_is_checked_too(refused, tmp_path, node, message):
    path = xml(tmp_path, node)
    trees = """<BehaviorTree ID="To"><Drop container="{to}"/></BehaviorTree>
      <BehaviorTree ID="Go"><MoveToConfiguration configuration="{to}"/></BehaviorTree></root>"""
    path.write_text(path.read_text().replace("</root>", trees))
    assert message in refused(path)


def test_an_object_that_a_goal_names_and_the_scene_lacks(refused, tmp_path):
    path = xml(tmp_path, "<AlwaysSuccess/>")
    goal = '<BehaviorTree _goal="IsIn object=cub container=basket" '
    path.write_text(path.read_text().replace("<BehaviorTree ", goal))
    message = refused(path)
    assert "task.xml:2:" in message and "no object 'cub'" in message


def test_objects_that_the_tree_adds_are_known(bt_manip, tmp_path):
    adding = '<Sequence><SpawnObject model="cube" name_hint="part"/>{}</Sequence>'
    assert bt_manip("run", xml(tmp_path, adding.format('<ObjectExists object="part"/>'))).code == 0
    resting = adding.format('<WaitUntilAtRest object="part"/>')
    assert bt_manip("run", xml(tmp_path, resting)).code == 0
    assert (
        bt_manip("run", xml(tmp_path, resting.replace('object="part"', 'object="prt"'))).code == 2
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--cycles", "-1"), "-1"),
        (("--cycles", "many"), "many"),
        (("--seed", "-5"), "-5"),
        (("--tick", "0"), "tick"),
        (("--tick", "2.5"), "whole number of control steps"),
        (("--tick", "nan"), "tick"),
        (("--real-time", "-1"), "real-time"),
        (("--set", "name"), "KEY=VALUE"),
        (("--set", "nme=x"), "did you mean 'name'"),
        (("--trace", "missing/t.npz"), "missing"),
        (
            ("--record", "run.txt"),
            "no recorder writes '.txt' files, known are .",
        ),
        (("--record", "missing/run.mcap"), "missing"),
        (("--record", "run.npz fps=3"), "recorder 'trace' has no parameter 'fps'"),
        (("--no-such-option",), "no-such-option"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_options_that_cannot_be(refused, trees, options, message):
    assert message in refused("small_trees.py:quick", *options)


def test_a_setting_that_the_xml_does_not_declare(refused):
    message = refused("pick_place", "--set", "forse=40")
    assert "forse" in message and "did you mean 'force'" in message


@pytest.mark.parametrize("place", ["missing/report.json", "."])
def test_an_unwritable_report(refused, tmp_path, place):
    message = refused("small_trees.py:quick", report_path=tmp_path / place)
    assert "cannot be written" in message


def test_report_and_trace_in_one_file(refused, tmp_path):
    report = tmp_path / "report.json"
    assert "both" in refused("small_trees.py:quick", "--trace", report)


def test_an_unknown_command_and_an_unknown_kind(bt_manip):
    assert bt_manip("rn").code == 2
    assert bt_manip("list", "gadgets").code == 2


SCENE = "[[robots]]\nposition = [{x}, 0.0, 1.015]\n"
DEEP = "a = " + "[" * 100_000 + "]" * 100_000


@pytest.mark.parametrize(
    ("option", "name", "text", "message"),
    [
        ("--scene", "s.toml", DEEP, "s.toml: not a TOML file: nested deeper than 64 levels"),
        ("--scene", "s.toml", SCENE.format(x="nan"), "s.toml:2: key 'robots[1].position' is a"),
        ("--scene", "s.toml", SCENE.format(x="1e300"), "of at most 1e+10 in size, got 1e+300"),
        (
            "--scene", "s.toml",
            SCENE.format(x=0) + "[randomization.objects.cube]\nmass = { uniform = [-1, 1] }\n",
            "mass must be a number above 0 and at most 1e+10 [kg], got -1",
        ),
        ("--resume", "/dev/zero", None, "cannot read the snapshot /dev/zero: not a regular file"),
        ("--resume", ".", None, "cannot read the snapshot .: a folder"),
    ],
    ids=lambda value: str(value)[:30],
)  # fmt: skip
def test_a_hostile_file_is_one_line(refused, trees, tmp_path, option, name, text, message):
    if text is not None:
        (tmp_path / name).write_text(text)
    assert message in refused("small_trees.py:quick", option, name)


def test_a_mapping_is_read_for_documents_and_refused_for_trees_in_python(refused, trees, tmp_path):
    path = tmp_path / "m.toml"
    path.write_text(DEEP)
    assert "m.toml: nested deeper than 64 levels" in refused("pick_place", "--map", path)
    message = refused("small_trees.py:quick", "--map", path)
    assert "--map: 'small_trees.py:quick' is made in Python" in message


@pytest.mark.parametrize("named", ["/dev/zero", "pipe", "."])
def test_an_include_of_no_file_is_refused_at_once(refused, tmp_path, named):
    os.mkfifo(tmp_path / "pipe")
    path = tmp_path / "task.xml"
    path.write_text(
        f'<root BTCPP_format="4"><include path="{named}"/>'
        '<BehaviorTree ID="Main"><AlwaysSuccess/></BehaviorTree></root>'
    )
    message = refused(path)
    assert "task.xml:1:33:" in message and "cannot be read: " in message


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("home = [0.0, 0.0]", "home = [0.0, 9.0]", "home: joint 2 cannot go to 9.0000 rad"),
        ("jerk = 500.0", "jerk = inf", "r.toml:7: key 'jerk' is a finite number of at most"),
        ('model = "post.xml"', 'model = "broken.xml"', "broken.xml:1:9: not XML"),
    ],
)
def test_a_robot_that_cannot_be_is_one_line(refused, trees, tmp_path, old, new, message):
    models = Path(__file__).parent.parent / "robots" / "models"
    for file in models.iterdir():
        (tmp_path / file.name).write_text(file.read_text())
    (tmp_path / "broken.xml").write_text("<mujoco>")
    (tmp_path / "r.toml").write_text((models / "post.toml").read_text().replace(old, new, 1))
    assert message in refused("small_trees.py:quick", "--robot", "r.toml")
