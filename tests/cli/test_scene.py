"""bt-manip scene check and show, and runs in scenes from files."""

import json
import re

import pytest

SCENE = """
about = "a cube on a table"
seed = 4
[[robots]]
position = [-0.1, 0.0, 1.015]
[[objects]]
model = "table"
[[objects]]
model = "cube"
name = "block"
on = "table"
position = [0.3, 0.1]
rpy = [0.0, 0.0, 0.5]
mass = 0.2
[randomization.objects.block]
mass = { uniform = [0.1, 0.2] }
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


def test_show_tells_what_stands_where_and_what_varies(bt_manip, scene):
    code, out, err = bt_manip("scene", "show", scene)
    assert (code, err) == (0, "")
    *lines, last = out.splitlines()
    assert lines == [
        "a cube on a table",
        "seed 4",
        "robots:",
        "  panda: panda, at -0.100 0.000 1.015 m",
        "objects:",
        "  table: table (surface, 24 kg), at 0.000 0.000 0.000 m",
        "  block: cube (graspable, 0.2 kg), at 0.300 0.100 1.040 m, turned by 0.000 0.000 0.500 "
        "rad, on 'table'",
        "varies from cycle to cycle, in the first one:",
    ]
    mass = re.fullmatch(r"  objects block: mass (0\.1\d+)", last)
    assert mass and 0.1 <= float(mass[1]) <= 0.2


def test_check_prints_all_findings_each_with_its_place(bt_manip, scene):
    scene.write_text(SCENE.replace("rpy", "rpz").replace("seed = 4", "seed = true"))
    code, out, err = bt_manip("scene", "check", scene)
    assert code == 2
    assert out.splitlines() == [
        f"{scene}:3: key 'seed' is a whole number, got True",
        f"{scene}:13: key 'objects[2].rpz' means nothing; did you mean 'rpy'?",
    ]
    assert err == "1 scene: 2 errors\n"
    assert bt_manip("scene", "check", "table_and_basket") == (0, "", "1 scene: 0 errors\n")


def test_check_finds_what_would_stand_inside_something_else(bt_manip, scene):
    scene.write_text(SCENE.replace("position = [0.3, 0.1]", "position = [0.3, 0.1, -0.02]"))
    code, out, _ = bt_manip("scene", "check", scene)
    assert code == 2
    assert out.startswith(
        f"{scene}: 'block' cannot be added: 'block' would be 20.0 mm inside 'table'"
    )


def test_what_cannot_be_drawn_is_bad_input(bt_manip, scene, trees):
    scene.write_text(SCENE.replace("uniform = [0.1", "uniform = [-0.1").replace("0.2] }", "0.0] }"))
    for command in (("scene", "check", scene), ("run", f"{trees}:quick", "--scene", scene)):
        code, out, err = bt_manip(*command)
        assert code == 2
        finding = f"{scene}: the mass of 'block' is a number above 0 and at most 1e+10 [kg]"
        assert finding in out + err


def test_a_run_takes_a_file_and_its_seed(bt_manip, scene, trees, tmp_path):
    report = tmp_path / "report.json"
    options = ("--scene", scene, "--set", "name=block", "--quiet", "--report", report)
    assert bt_manip("run", f"{trees}:quick", *options).code == 0
    first = json.loads(report.read_text())
    assert first["seed"] == 4
    assert bt_manip("run", f"{trees}:quick", *options, "--seed", 5).code == 0
    second = json.loads(report.read_text())
    assert second["seed"] == 5
    masses = [r["cycles"][0]["randomized"]["objects"]["block"]["mass"] for r in (first, second)]
    assert masses[0] != masses[1]


def test_a_scene_that_names_its_robot_by_its_role_takes_another_robot(
    bt_manip, menagerie, monkeypatch, trees, tmp_path
):
    monkeypatch.setenv("MENAGERIE_ROOT", str(menagerie))
    report = tmp_path / "report.json"
    options = ("--scene", "varied_pick", "--robot", "xarm7", "--quiet", "--report", report)
    code, _, err = bt_manip("run", f"{trees}:quick", *options)
    assert (code, err) == (0, "")
    (cycle,) = json.loads(report.read_text())["cycles"]
    assert cycle["randomized"]["robots"].keys() == {"arm"}
