"""bt-manip run: what it prints, writes and returns."""

import hashlib
import json
import re
import shutil

import numpy as np
import pytest

from bt_manip.record import read_report
from bt_manip.runner.run import Run


def test_a_tree_that_succeeds_is_0_and_ends_with_a_table(bt_manip, trees):
    code, out, err = bt_manip("run", f"{trees}:quick")
    assert code == 0
    assert "SUCCESS" in out
    assert "1 of 1 cycles succeeded" in out
    assert err == ""
    assert bt_manip("run", f"{trees}:quick", "--quiet") == (0, "", "")


def test_a_tree_that_fails_is_1_and_says_why_and_how_to_watch_it(bt_manip, trees, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    code, out, _ = bt_manip("run", f"{trees}:failing")
    assert code == 1 and "0 of 1 cycles succeeded" in out and "look" in out
    assert max(map(len, out.splitlines())) <= 60
    assert "Options" not in out and "\x1b" not in out
    hint = "To watch the failure: the same command with --record run.mcap --view"
    assert " ".join(out.split()).endswith(hint)
    code, out, err = bt_manip("run", f"{trees}:failing", "--quiet")
    assert (code, out) == (1, "")
    assert err.startswith("cycle 1 failed: ") and "look" in err


def test_success_with_the_cube_on_the_table_is_1_if_the_goal_is_the_basket(
    bt_manip, task, tmp_path
):
    spawn = '<Sequence><SpawnObject object="{cube}"/><Sleep msec="300"/></Sequence>'
    report = tmp_path / "report.json"
    tree = task(spawn, '_goal="IsIn object={cube} container=basket"')
    code, out, _ = bt_manip("run", tree, "--report", report)
    assert code == 1
    assert "cycle 1: goal not met: 'cube' touches 'table'" in out
    assert "0 of 1 cycles succeeded" in out
    read = read_report(report)
    assert (read.status, read.cycles[0].goal) == ("FAILURE", False)
    assert read.cycles[0].goal_reason == "'cube' touches 'table'"


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize("name", ["report.json", "report.jsonl"])
def test_the_report_says_what_was_run(bt_manip, site, trees, tmp_path, name):
    source = "from bt_manip import hookimpl\n\n@hookimpl\ndef after_tick(): pass\n"
    site("noisy", source, "[bt_manip]\nnoisy = noisy\n")
    path = tmp_path / name
    options = "--set", "name=basket", "--tick", 5, "--controller", "gravity_compensated_pd"
    options = *options, "--fault", "push at=rest"
    assert bt_manip("run", f"{trees}:quick", "--report", path, *options).code == 0
    read = read_report(path)
    assert (read.tree, read.robot, read.scene) == (f"{trees}:quick", "panda", "table_and_basket")
    assert (read.controller, read.planner) == ("gravity_compensated_pd", "rrt_connect")
    assert (read.settings, read.modifiers) == ({"name": "basket"}, {"fault": ("push at=rest",)})
    assert (read.tick_s, read.time_step_s) == (0.005, 0.001)
    assert read.plugins["noisy"] == "2.5" and "builtin" not in read.plugins
    assert read.sha256[trees.name] == sha256(trees)


def test_included_trees_and_files_of_scenes_and_robots_are_in_the_report(bt_manip, tmp_path):
    part, tree, scene, report = (tmp_path / f for f in ("p.xml", "t.xml", "s.toml", "r.json"))
    part.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="Part"><Sleep msec="20"/></BehaviorTree></root>'
    )
    tree.write_text(
        '<root BTCPP_format="4" main_tree_to_execute="Main"><include path="p.xml"/>'
        '<BehaviorTree ID="Main"><SubTree ID="Part"/></BehaviorTree></root>'
    )
    scene.write_text('[[robots]]\nname = "left"\nrobot = "panda"\n')
    code, _, err = bt_manip("run", tree, "--scene", scene, "--report", report)
    assert code == 0, err
    found = read_report(report).sha256
    for path in (part, tree, scene):
        assert found[path.name] == sha256(path)


def test_a_varied_quantity_of_an_object_that_never_was_there_is_a_warning(bt_manip, trees):
    absent, there = "scene.objects.bottle.mass", "controller.kp"
    code, _, err = bt_manip("run", f"{trees}:quick", "--vary", f"{absent}=1", "--cycles", 2)
    assert code == 0 and err.count(f"{absent}: no such object was ever in the cell") == 1
    assert bt_manip("run", f"{trees}:quick", "--vary", f"{there}=900").err == ""


def test_the_end_of_a_file_is_no_interrupt(bt_manip, trees, monkeypatch):
    def ended(*arguments):
        raise EOFError("a process ended")

    monkeypatch.setattr("bt_manip.cli.session.execute_run", ended)
    code, _, err = bt_manip("run", f"{trees}:quick")
    assert code == 3 and "EOFError: a process ended" in err


ESCAPES = re.compile(r"\x1b\[[0-9;?]*\w")


def test_at_a_terminal_the_last_line_says_what_to_try_next(bt_manip, screen, trees, monkeypatch):
    read = screen()
    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.setenv("NO_COLOR", "1")
    assert bt_manip("run", f"{trees}:quick").code == 0
    shown = read()
    assert not re.search(r"\x1b\[[0-9;]*3\dm", shown)  # no colour
    *_, table = shown.split("\x1b[?25h")
    lines = ESCAPES.sub("", table).splitlines()
    assert max(map(len, lines)) <= 60
    last = f"{lines[-2]} {lines[-1].strip()}"
    assert last == "Options to try next: --window, --view, --cycles 10, --real-time 1"
    assert bt_manip("run", f"{trees}:quick", "--cycles", 2, "--real-time", 0).code == 0
    assert read().splitlines()[-1] == "Options to try next: --window, --view"


def test_watching_and_writing_leave_the_run_as_it_is(digest, trees, tmp_path):
    tree = f"{trees}:quick"
    plain = digest(tree)
    assert digest(tree, "--quiet") == plain
    assert digest(tree, "--trace", tmp_path / "t.npz") == plain
    assert digest(tree, "--real-time", 1000) == plain
    assert digest(tree, "--tick", 5) != plain
    assert digest(tree, "--controller", "gravity_compensated_pd") != plain


def test_a_behaviour_that_raises_is_3_with_its_report_and_its_traceback(bt_manip, trees, tmp_path):
    report, trace = tmp_path / "report.json", tmp_path / "t.npz"
    code, _, err = bt_manip("run", f"{trees}:loud", "--report", report, "--trace", trace)
    assert code == 3
    assert "so loud" in err.splitlines()[-1]
    assert "Shout" in err.splitlines()[-1]
    assert "small_trees.py" in err
    read = json.loads(report.read_text())
    assert read["status"] == "ERROR"
    assert "so loud" in read["error"]
    assert read["simulated_s"] == pytest.approx(0.02)
    assert read["cycles"][0]["status"] == "ERROR"
    with np.load(trace) as rows:
        assert len(rows["t"]) == 20


LEAF = """
from bt_manip import hookimpl
from bt_manip.bt import Action, Output


class Word(Action):
    written = Output(float, doc="A number.")

    def update(self):
        self.written = "long"


@hookimpl
def register_behaviours(register):
    register(Word)
"""


@pytest.mark.parametrize(
    ("node", "reason"),
    [
        ('<Word written="{x}"/>', "plugin 'leaf': .* expected double, found 'long'"),
        (
            '<Sleep msec="{rest}"/>',
            "port 'msec' of Sleep::1: the blackboard entry 'rest' was never written",
        ),
        (
            '<Sequence><Script code="n := 1"/><Script code="n := missing + 1"/></Sequence>',
            "variable not found: missing",
        ),
        (
            f"<Script code=\"x := 'abcdefgh'; {'; '.join(['x := x .. x'] * 60)}\"/>",
            "error in script .x := 'abcdefgh'; .*: a text is longer than 1000000 characters",
        ),
    ],
)
def test_a_mistake_in_a_tree_or_leaf_is_one_line_with_its_place_and_no_internal_fault(
    bt_manip, task, tmp_path, node, reason
):
    (tmp_path / "leaf.py").write_text(LEAF)
    tree = task(node)
    code, _, err = bt_manip("run", tree, "--plugins-dir", tmp_path)
    assert code == 1 and "Traceback" not in err and "internal" not in err
    (line,) = [line for line in err.splitlines() if line.startswith("Error")]
    assert re.fullmatch(rf"Error: {re.escape(str(tree))}:3:\d+: .*{reason}", line)
    assert len(line) < 240 + len(str(tree))


def test_a_failed_cycle_does_not_stop_a_run_but_ten_that_fail_at_once_do(bt_manip, task, tmp_path):
    tree, path = task("<AlwaysFailure/>"), tmp_path / "report.json"
    code, _, err = bt_manip("run", tree, "--cycles", 0, "--report", path)
    assert code == 1 and "10 cycles in a row failed within 0.1 s: AlwaysFailure" in err
    report = read_report(path)
    assert (report.tree, report.status) == (str(tree), "FAILURE")
    assert [cycle.status for cycle in report.cycles] == ["FAILURE"] * 10
    assert "10 cycles" in report.ended_early


def test_results_of_a_tree_are_columns_of_the_table(bt_manip, task):
    tree = task('<Script code="left := 3; right := 0.25"/>', '_results="left right"')
    code, out, _ = bt_manip("run", tree)
    assert code == 0 and re.search(r"left +right", out) and re.search(r" 3 +0\.25 ", out)


def test_help_lists_options_in_groups_and_a_mistyped_command_gets_a_suggestion(bt_manip):
    out = bt_manip("run", "--help").out
    titles = re.findall(r"^(\w[\w ]+):$", out, re.MULTILINE)
    assert titles[:4] == ["Cell and robot", "Task", "Views", "Files"] and titles[-1] == "Options"
    code, _, err = bt_manip("rnu")
    assert code == 2 and "did you mean 'run'?" in err


def test_without_a_display_the_window_is_missed_and_the_run_goes_on(bt_manip, trees, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    code, _, err = bt_manip("run", f"{trees}:quick", "--window")
    assert code == 0
    assert "there is no display" in err


@pytest.mark.parametrize("name", ["report.json", "report.jsonl"])
def test_a_folder_that_goes_away_meanwhile_is_an_error_and_no_traceback(
    bt_manip, trees, tmp_path, monkeypatch, name
):
    folder = tmp_path / "reports"
    folder.mkdir()
    execute = Run.execute
    monkeypatch.setattr(Run, "execute", lambda *a, **k: (execute(*a, **k), shutil.rmtree(folder)))
    code, _, err = bt_manip("run", f"{trees}:quick", "--report", folder / name)
    assert code == 3
    assert f"report '{folder / name}' cannot be written" in err
    assert "cycle 1 is the first that is lost" in err
    assert "Traceback" not in err


def test_configurations_are_named_by_a_file(bt_manip, task, tmp_path):
    tree = task('<MoveToConfiguration configuration="above"/>')
    file = tmp_path / "configurations.toml"
    file.write_text("[configurations]\nabove = [0, -0.7, 0, -2.2, 0, 1.6, 0.8]\n")
    assert bt_manip("run", tree, "--configurations", file).code == 0
    refused = bt_manip("run", tree)
    assert refused.code == 2 and "no configuration is named 'above'" in refused.err
