"""Bad input: exit 2, one clear message, no traceback, nothing simulated, nothing written."""

import errno
import gc
import os
from pathlib import Path

import pytest

from bt_manip.runner.run import Run


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


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        ("pick_plce", "unknown tree 'pick_plce'; did you mean 'pick_place' or "),
        ("no_such_module_anywhere:tree", "no_such_module_anywhere"),
        ("small_trees.py:no_tree", "int"),
        ("small_trees.py:broken", "small_trees.py:28: no tree today"),
        ("small_trees.py", "write 'small_trees.py:NAME'"),
        ("small_trees.py:quik", "did you mean 'quick'"),
        ("smal_trees.py:quick", "did you mean 'small_trees.py'"),
        ("tsk.xml", "did you mean 'task.xml'"),
        ("nowhere/task.xml", "no folder"),
        ("folder.xml", "'folder.xml' is a folder; a tree is a file"),
        ("folder.py:make", "'folder.py' is a folder; a tree is a file"),
        ("folder", "'folder' is a folder; a tree is a file"),
    ],
)
def test_an_argument_that_is_no_tree(refused, tmp_path, tree, message):
    (tmp_path / "task.xml").touch()
    for name in ("folder.xml", "folder.py", "folder"):
        (tmp_path / name).mkdir()
    assert message in refused(tree)
    assert gc.isenabled()


@pytest.mark.parametrize("name", ["a.xml", "a.py:make", "cube.xml"])
def test_a_folder_that_one_may_not_enter(refused, monkeypatch, name):
    """A superuser, as whom tests may run, may enter any: the system's answer is replaced."""
    real = os.stat

    def stat(path, **options):
        if str(path).startswith("shut/"):
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return real(path, **options)

    monkeypatch.setattr(os, "stat", stat)
    path = f"shut/{name}"
    text = refused("pick_place", "--set", f"cube={path}") if "cube" in name else refused(path)
    assert f"'{path.partition(':')[0]}': Permission denied" in text


SUB_TREES = (  # on line 4
    '<BehaviorTree ID="To"><Drop container="{to}"/></BehaviorTree>'
    '<BehaviorTree ID="Go"><MoveToConfiguration configuration="{to}"/></BehaviorTree></root>'
)


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ('<Hovr object="cube"/>', "did you mean 'Hover'"),
        ('<SpawnObject model="cub" object="{o}"/>', "did you mean 'cube'"),
        ('<Hover object="cub"/>', "port 'object' of Hover: no object 'cub'; known: basket, "),
        ('<Drop container="bskt"/>', "port 'container' of Drop: no object 'bskt'; did you mean"),
        ('<IsIn object="part_*" container="basket"/>', "no object is called 'part_*'; there are "),
        ('<IsIn object="kind:can" container="basket"/>', "table (table), basket (basket)"),
        ('<SubTree ID="To" to="bskt"/>', "port 'container' of Drop: no object 'bskt'; did you"),
        (
            '<Sequence><Script code="to := \'bskt\'"/><Drop container="{to}"/></Sequence>',
            "port 'container' of Drop: no object 'bskt'; did you mean 'basket'?",
        ),
        ('<SubTree ID="Go" to="hom"/>', "no configuration is named 'hom'; did you mean 'home'?"),
    ],
)
def test_a_mistake_in_a_document_is_placed_at_its_line(refused, task, node, message):
    path = task(node)
    path.write_text(path.read_text().replace("</root>", SUB_TREES))
    error, line = refused(path), 4 if "SubTree" in node else 3
    assert message in error and f"task.xml:{line}:" in error


@pytest.mark.parametrize(
    ("attribute", "options", "messages"),
    [
        (
            '_goal="IsInn object=a container=b"',
            "",
            ["task.xml:2:32: error: _goal: no condition is named 'IsInn'"],
        ),
        ('_goal="IsIn object=cub container=basket"', "", ["task.xml:2:", "no object 'cub'"]),
        (
            '_goal="IsHolding object=a"',
            "--scene two_arms",
            ["goal/IsHolding: ", "select one by the port robot"],
        ),
        ('_results="left;right"', "", ["task.xml:2:", "expected keys separated by spaces"]),
        ('_continues="yes"', "", ["task.xml:2:", "expected 'true' or 'false'"]),
    ],
)
def test_an_attribute_that_the_tree_cannot_have(refused, task, attribute, options, messages):
    error = refused(task("<AlwaysSuccess/>", attribute), *options.split())
    assert all(message in error for message in messages)


def test_an_evaluation_checks_the_objects_of_its_tree_too(bt_manip, task):
    code, _, err = bt_manip("evaluate", task('<Hover object="cub"/>'), "--episodes", 2)
    assert code == 2 and "task.xml:3:" in err and "no object 'cub'; known: basket, " in err


def test_objects_that_the_tree_adds_are_known(bt_manip, task):
    adding = '<Sequence><SpawnObject model="cube" name_hint="part"/>{}</Sequence>'
    resting = adding.format('<WaitUntilAtRest object="part"/>')
    assert bt_manip("run", task(resting)).code == 0
    assert bt_manip("run", task(resting.replace('object="part"', 'object="prt"'))).code == 2


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
        (("--record", "run.txt"), "no recorder writes '.txt' files, known are ."),
        (("--record", "missing/run.mcap"), "missing"),
        (("--record", "run.npz fps=3"), "recorder 'trace' has no parameter 'fps'"),
        (("--no-such-option",), "no-such-option"),
        (("--robot", "pnda"), "unknown robot 'pnda'; did you mean 'panda'?"),
        (("--controller", "computed_torqe"), "did you mean 'computed_torque'"),
        (("--scene", "table_and_baskett"), "did you mean 'table_and_basket'"),
        (("--scene", "none.toml"), "no scene none.toml: No such file"),
        (("--scene", "pick.xml"), "'pick.xml' is a tree; a scene is a registered name or path"),
        (("--scene", "trees/pick.py:pick"), "'trees/pick.py:pick' is a tree; a scene is"),
        (("--snapshot-at", "1", "missing/x.json"), "snapshot"),
        (("--snapshot-at", "-1", "x.json"), "-1"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_options_that_cannot_be(refused, trees, options, message):
    assert message in refused("small_trees.py:quick", *options)


@pytest.mark.parametrize("place", ["missing/report.json", "."])
def test_an_unwritable_report(refused, tmp_path, place):
    message = refused("small_trees.py:quick", report_path=tmp_path / place)
    assert "cannot be written" in message


def test_report_and_another_output_in_one_file(refused, tmp_path):
    for option in ("--trace",), ("--snapshot-at", 1):
        message = refused("small_trees.py:quick", *option, tmp_path / "report.json")
        assert "cannot both be" in message


SCENE = "[[robots]]\nposition = [{x}, 0.0, 1.015]\n"
DEEP = "a = " + "[" * 100_000 + "]" * 100_000


@pytest.mark.parametrize(
    ("option", "name", "text", "message"),
    [
        ("--scene", "s.toml", DEEP, "s.toml: not a TOML file: nested deeper than 64 levels"),
        ("--scene", "s.toml", SCENE.format(x="nan"), "s.toml:2: key 'robots[1].position' is a"),
        ("--scene", "s.toml", SCENE.format(x="1e300"), "of at most 1e+10 in size, got 1e+300"),
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
