"""What each hook brings in is used; the plugins are the examples of the documentation."""

import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.exceptions import BtManipError
from bt_manip.models import ModelError, load_model
from bt_manip.planning import PlanningProblem
from bt_manip.plugins import PluginSelection, load_plugins
from bt_manip.robots import GripperError, panda
from bt_manip.spatial import pose
from bt_manip_contracts.contract_list import checks_of
from tests.support.program import bt_manip as bt_manip

PAGES = Path(__file__).resolve().parents[2] / "docs" / "plugins" / "hooks"
WAIT = """<root BTCPP_format="4"><BehaviorTree ID="Main">{}</BehaviorTree></root>"""


@pytest.fixture
def example(tmp_path):
    """Put the example of a hook's page into a folder of plugins."""
    folder = tmp_path / "plugins"
    folder.mkdir()

    def put(hook: str, extra: str = "") -> Path:
        page = PAGES / f"{hook}.md"
        text = (page if page.exists() else PAGES / "observers.md").read_text()
        section = text[text.index(f"# `{hook}(") :]
        code = re.findall(r"```python\n(.*?)```", section, re.DOTALL)[0]
        (folder / f"of_{hook}.py").write_text(code + extra)
        return folder

    yield put
    for name in [name for name in sys.modules if name.startswith("_bt_manip_plugin_")]:
        del sys.modules[name]


@pytest.fixture
def plugins_of(example):
    def load(hook: str):
        choice = PluginSelection(folders=(example(hook),))
        return load_plugins(entry_points=(), warn=pytest.fail, choice=choice)

    return load


@pytest.fixture
def parts_of(plugins_of):
    return lambda hook: plugins_of(hook).parts


@pytest.fixture
def run(bt_manip, example, tmp_path):
    """Run a tree with the example of a hook's page; give what was printed."""

    def run(hook: str, *options: object, tree="", body='<Sleep msec="30"/>', extra="") -> str:
        if not tree:
            tree = tmp_path / "task.xml"
            tree.write_text(WAIT.format(body))
        folder = example(hook, extra)
        code, out, err = bt_manip("run", tree, "--plugins-dir", folder, *options)
        assert (code, err) == (0, "")
        return out

    return run


def test_register_objects_makes_things_that_can_stand_in_a_cell(parts_of):
    station = build_station(parts_of("register_objects"))
    name = station.cell.add(station.models.create("puck"), pose((0.4, 0.2, 1.03)))
    station.cell.step(300)
    assert station.cell.pose(name).translation[2] == pytest.approx(1.03, abs=1e-3)


def test_register_robots_makes_arms_that_can_be_chosen(parts_of):
    station = build_station(parts_of("register_robots"), robot="careful_panda")
    assert station.arm.model.limits.velocity[0] == pytest.approx(2.175 / 2)


def test_register_grippers_makes_kinds_that_descriptions_can_name(parts_of):
    parts = parts_of("register_grippers")
    described = panda()
    gentle = replace(described.gripper, kind="gentle")
    parts.robots.add("gentle_panda", replace(described, gripper=gentle), "this test")
    station = build_station(parts, robot="gentle_panda")
    assert type(station.gripper).__name__ == "GentleGripper"
    with pytest.raises(GripperError, match="up to 20 N, not 50 N"):
        station.gripper.close(50.0)


def test_register_controllers_makes_controllers_that_can_be_chosen(parts_of):
    station = build_station(parts_of("register_controllers"), controller="gentle")
    station.cell.step(500)
    assert abs(station.robot.q - station.arm.q).max() < 0.01
    assert type(station.controller).__name__ == "Gentle"


def test_the_controller_of_the_page_is_good_for_a_whole_task(run):
    assert "goal met in 1" in run(
        "register_controllers", "--controller", "gentle", tree="pick_place"
    )


def test_register_planners_makes_planners_that_the_arm_asks(parts_of):
    station = build_station(parts_of("register_planners"), planner="patient")
    start = station.arm.q_ref
    goal = start + 0.5
    problem = PlanningProblem(
        start, goal[np.newaxis], lambda q: True, station.arm.model.limits, station.rng
    )
    assert type(station.arm.planner).__name__ == "Patient"
    np.testing.assert_array_equal(station.arm.planner.plan(problem).path[-1], goal)


def test_register_behaviours_makes_nodes_of_trees(run):
    wait = '<Sequence><Sleep msec="60"/><IsWarm after="0.05"/></Sequence>'
    assert "SUCCESS" in run("register_behaviours", body=wait)


def test_register_trees_makes_trees_by_name_with_their_surroundings(run, parts_of):
    assert "SUCCESS" in run("register_trees", tree="clap")
    clap = parts_of("register_trees").tree_defaults["clap"]
    assert (clap.controller, clap.scene) == ("gravity_compensated_pd", None)


def test_register_scenes_makes_what_stands_in_the_cell(run, parts_of):
    body = '<ObjectExists object="cube"/>'
    assert "SUCCESS" in run("register_scenes", "--scene", "two_tables", body=body)
    parts = parts_of("register_scenes")
    station = build_station(parts, scene=parts.scenes.create("two_tables"))
    assert set(station.cell.objects) >= {"table", "cube"}
    cube = station.cell.body_id("cube")
    assert station.cell.model.body_subtreemass[cube] == pytest.approx(0.1)


def test_register_model_sources_finds_models_that_objects_are_made_of(parts_of, tmp_path):
    station = build_station(parts_of("register_model_sources"))
    shelf = tmp_path / "plugins" / "shelf"
    shelf.mkdir()
    (shelf / "ball.xml").write_text(
        "<mujoco><worldbody><geom type='sphere' size='0.0234'/></worldbody></mujoco>"
    )
    name = station.cell.add(station.models.create("shelf:ball"), pose((0.4, 0.2, 1.2)))
    assert name == "ball"
    assert 0.0234 in station.cell.model.geom_size[:, 0]
    with pytest.raises(Exception, match="no such model in"):
        station.models.create("shelf:nothing")


def test_register_model_formats_converts_files_that_objects_are_made_of(parts_of, tmp_path):
    parts = parts_of("register_model_formats")
    (tmp_path / "red.ball").write_text("0.0234")
    station = build_station(parts)
    thing = station.models.create(str(tmp_path / "red.ball"))
    assert thing.free
    station.cell.add(thing, pose((0.4, 0.2, 1.2)))
    assert 0.0234 in station.cell.model.geom_size[:, 0]
    (tmp_path / "red.ball").write_text("red")
    with pytest.raises(ModelError, match="expected a radius"):
        load_model(str(tmp_path / "red.ball"), formats=parts.model_formats.copies())


@pytest.mark.parametrize(
    ("clash", "taken"), [('suffixes=(".urdf",)', ".urdf"), ('tag="mujoco"', "mujoco")]
)
def test_a_suffix_or_root_element_belongs_to_one_format(example, clash, taken):
    folder = example("register_model_formats")
    (file,) = folder.glob("*.py")
    file.write_text(file.read_text().replace('suffixes=(".ball",)', clash))
    warnings: list[str] = []
    plugins = load_plugins(
        entry_points=(), warn=warnings.append, choice=PluginSelection(folders=(folder,))
    )
    assert f"'ball': '{taken}' belongs to the format" in warnings[0]
    assert "ball" not in plugins.parts.model_formats


def test_register_model_caches_lists_fetches_and_deletes_models(bt_manip, example):
    folder = example("register_model_caches")
    (folder / "shelf").mkdir()
    mug = folder / "shelf" / "mug.xml"
    mug.touch()

    def models(*arguments: str) -> str:
        _, out, err = bt_manip("models", *arguments, "--plugins-dir", folder)
        return out + err

    assert models("list", "shelf") == "shelf:mug\n"
    assert "shelf:mug" in models("list").splitlines()
    assert models("fetch", "shelf:mug") == f"shelf:mug  {mug}\n"
    assert "no such model" in models("fetch", "shelf:cup")
    assert models("clear", "shelf:mug") == f"deleted {mug}\n"
    assert not mug.exists()


def test_register_dialects_reads_trees_of_others(run, tmp_path):
    run("register_dialects", body='<Chain><Nap msec="30"/></Chain>')
    with pytest.raises(AssertionError):
        run("register_dialects", "--dialect", "btcpp", body="<Chain/>")


def test_register_conversions_writes_trees_in_another_language(bt_manip, example, tmp_path):
    (tmp_path / "task.xml").write_text(WAIT.format('<Sleep msec="30"/>'))
    options = "--to", "outline", "--plugins-dir", example("register_conversions")
    converted = bt_manip("tree", "convert", tmp_path / "task.xml", *options)
    assert converted == (0, "Main: Sleep\n", "")


def test_register_backends_makes_robots_that_can_be_chosen(parts_of):
    parts = parts_of("register_backends")
    with pytest.raises(BtManipError, match="--backend wants acme=ADDRESS, where ADDRESS is the co"):
        build_station(parts, backend="acme=")
    with pytest.raises(BtManipError, match="'acme' has no controller 'computed_torque'"):
        build_station(parts, backend="acme=192.168.0.2")


def test_register_pose_sources_tells_where_expected_objects_are(parts_of, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'robots = [{position = [-0.1, 0.0, 1.015]}]\n[[objects]]\nmodel = "table"\n[[objects]]\n'
        'model = "cube"\non = "table"\nposition = [0.3, 0.1]\nexpected = true\n'
    )
    station = build_station(parts_of("register_pose_sources"), scene=str(scene), poses="shifted")
    assert station.poses.add(station.poses.next().name)
    np.testing.assert_allclose(station.cell.pose("cube").translation[:2], [0.31, 0.1])


def test_register_recorders_writes_files_about_a_run(run, tmp_path):
    file = tmp_path / "heights.txt"
    run("register_recorders", "--record", f"heights={file}")
    times, heights = np.loadtxt(file).T
    assert len(times) >= 3 and (np.diff(times) > 0).all()
    assert (heights > 1.0).all()


def test_register_views_opens_views_by_options(bt_manip, run, example):
    assert "The tool is 1." not in run("register_views")
    shown = run("register_views", "--height", "--height-digits", "2", "--real-time", "0")
    assert re.search(r"The tool is 1\.\d\d m high\.", shown)
    folder = example("register_views")
    shown = " ".join(bt_manip("run", "--plugins-dir", folder, "--help").out.split())
    assert "--height Print the height of the tool after each cycle." in shown
    wrong = "--plugins-dir", folder, "--height-digits", 13
    code, _, err = bt_manip("run", "pick_place", *wrong)
    assert code == 2 and "must be a whole number from 1 to 12, got '13'" in err


def test_register_commands_adds_a_command(bt_manip, example):
    folder = example("register_commands")
    assert bt_manip("--plugins-dir", folder, "payload", "0.5") == (0, "1 kg\n", "")
    assert "Print the payload to declare" in bt_manip("--plugins-dir", folder, "--help").out


def test_register_modifiers_changes_a_run(run):
    extra = """
@hookimpl
def after_tick(station):
    print("gravity", station.cell.model.opt.gravity[2])
"""
    assert "gravity -1.62" in run("register_modifiers", "--gravity", "1.62", extra=extra)
    assert "gravity -9.81" in run("register_modifiers", extra=extra)


COUNTED = """

def half(make_worker, address, workers, made=half):
    print(f"address {address}, {workers} worker")
    return made(make_worker, address, workers)
"""


def test_register_pools_chooses_where_episodes_run(bt_manip, example, tmp_path):
    tree = tmp_path / "task.xml"
    tree.write_text(WAIT.format('<Sleep msec="30"/>'))
    folder = example("register_pools", COUNTED)
    words = "--episodes", 2, "--workers", 1, "--plugins-dir", folder, "--half"
    code, out, _ = bt_manip("evaluate", tree, *words)
    assert code == 0
    assert "address local, 1 worker" in out and "2 of 2 episodes succeeded" in out


def test_register_contracts_adds_checks_of_all_plugins(plugins_of):
    plugins = plugins_of("register_contracts")
    nothing = {"examples": {}, "parameters": {}, "settings": {}}
    checks = {one.id: one for one in checks_of(plugins, "builtin", **nothing)}
    checks["tree pick_place: has a goal"].run(None)
    assert "tree pick_place: goes on from its state" in checks


NOTES = """

import json
from pathlib import Path

LOG = Path(__file__).with_name("log.txt")


@hookimpl(specname="{hook}")
def note({arguments}):
    with LOG.open("a") as file:
        file.write({text} + "\\n")
"""


@pytest.fixture
def notes(run, tmp_path):
    """Run with a hook that writes a line each time; give the lines."""

    def write(hook: str, arguments: str, text: str, *options: object, **run_options) -> list[str]:
        extra = NOTES.format(hook=hook, arguments=arguments, text=text)
        run(hook, *options, extra=extra, **run_options)
        return (tmp_path / "plugins" / "log.txt").read_text().splitlines()

    return write


def test_after_compile_comes_first_and_after_each_change(notes):
    body = '<Sequence><Sleep msec="20"/><SpawnObject/><Sleep msec="20"/></Sequence>'
    lines = notes("after_compile", "station", "str('cube' in station.cell.objects)", body=body)
    assert lines == ["False", "True"]


def test_cycle_started_comes_once_a_cycle(notes):
    text = "f'{cycle} {tree.root.name} {station.cell.time:.2f}'"
    lines = notes("cycle_started", "station, tree, cycle", text, "--cycles", 2)
    assert [line.split()[0] for line in lines] == ["0", "1"]
    assert lines[0].endswith("0.00")


def test_before_tick_sees_the_state_that_the_tree_will_see(notes):
    lines = notes("before_tick", "station", "f'{station.cell.time:.2f}'")
    assert lines == ["0.00", "0.01", "0.02", "0.03"]


def test_after_tick_sees_the_state_after_the_control_steps(notes):
    lines = notes("after_tick", "station, tree", "f'{station.cell.time:.2f}'")
    assert lines == ["0.01", "0.02", "0.03", "0.04"]


def test_cycle_ended_is_told_how(notes):
    arguments = "cycle, status, reason"
    lines = notes("cycle_ended", arguments, "f'{cycle} {status} {reason}'", "--cycles", 2)
    assert [line.strip() for line in lines] == ["0 SUCCESS", "1 SUCCESS"]
