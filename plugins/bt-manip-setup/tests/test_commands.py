"""bt-manip robot new, check and show."""

import os
import subprocess
import sys

import pytest

import bt_manip_setup
from bt_manip.models import bundled_path
from bt_manip.robots import Robot, panda
from bt_manip_setup.trial import Checked
from tests.support.models import ROBOTS

PANDA = bundled_path("panda/panda.xml")


@pytest.fixture(scope="module")
def described(tmp_path_factory):
    return tmp_path_factory.mktemp("described") / "arm.toml"


def test_new_writes_a_description_over_a_file_when_asked_and_says_what_to_run_next(
    bt_manip, described, monkeypatch
):
    def tried(description, parts, cycles, report):
        return Checked([], [f"pick_place: {cycles} of {cycles} cycles"])

    monkeypatch.setattr(bt_manip_setup, "try_robot", tried)
    described.write_text("")
    code, _, err = bt_manip("robot", "new", PANDA, "-o", described)
    assert code == 2 and "exists: --overwrite replaces it, -o names another" in err
    code, out, err = bt_manip("robot", "new", PANDA, "-o", described, "--overwrite")
    assert (code, err) == (0, "pick_place: 20 of 20 cycles\n")
    assert out.splitlines() == [
        f"wrote {described}, ready:",
        f"  bt-manip run pick_place --robot {described} --view",
    ]
    assert described.read_text().startswith(f"# {PANDA}\n")
    assert "\n# The base stands on " in described.read_text()


def test_new_says_at_once_that_it_cannot_write(bt_manip, monkeypatch):
    monkeypatch.setattr(bt_manip_setup, "describe_robot", None)
    code, _, err = bt_manip("robot", "new", PANDA, "-o", "no/such/folder.toml")
    assert code == 2 and "'no/such/folder.toml' cannot be written: there is no folder" in err


def test_check_says_why_there_is_no_picture(bt_manip, monkeypatch):
    checked = Checked([], [], Robot(panda()))
    monkeypatch.setattr(bt_manip_setup, "check_description", lambda *_: checked)
    code, _, err = bt_manip("robot", "check", "arm.toml")
    assert code == 0 and "no picture: nothing can be drawn with MUJOCO_GL disable" in err


@pytest.mark.soak
def test_check_warns_of_nothing_without_a_display(described):
    unset = {k: v for k, v in os.environ.items() if k not in ("MUJOCO_GL", "DISPLAY")}
    command = [sys.executable, "-m", "bt_manip", "robot", "check", described, "--cycles", "0"]
    done = subprocess.run(command, env=unset, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "GLFW" not in done.stderr and "Error" not in done.stderr


def test_check_exits_with_1_if_there_are_findings(bt_manip, described, tmp_path):
    wrong = tmp_path / "wrong.toml"
    text = described.read_text().replace(str(PANDA.name), "no.xml")
    wrong.write_text(text.replace("velocity = [1.5", "velocity = [-1.5"))
    code, out, err = bt_manip("robot", "check", wrong)
    assert code == 1
    assert "key 'velocity' is a positive number [rad/s], got -1.5" in out
    assert err == f"{wrong}: 1 finding\n"


def test_check_saves_a_picture(opengl, bt_manip, described):
    code, out, err = bt_manip("robot", "check", described, "--cycles", "0")
    assert "GLFW" not in err
    assert (code, out) == (0, "")
    assert err.startswith("reach: ")
    assert described.with_suffix(".png").is_file() and "no picture" not in err
    assert err.endswith(f"{described}: 0 findings\n")


def test_show_prints_a_registered_robot(bt_manip):
    code, out, err = bt_manip("robot", "show", "panda")
    assert (code, err) == (0, "")
    assert "  joint1 " in out and "gripper: two_finger, up to 140 N" in out
    assert "reach: " in out and "payload: " in out and "; the grip holds " in out
    assert "base: on the plane where a scene places the robot, with its origin at 0 0 0 m" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("new", "nothing.xml"), "no model file nothing.xml"),
        (("new", PANDA, "--joints", "joint1,jont2"), "no joint 'jont2'; did you mean"),
        (("show", "pnda"), "did you mean 'panda'"),
        (("check", "panda"), "'panda' is a registered robot, and check takes a file"),
    ],
)
def test_bad_input_exits_with_2(bt_manip, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    code, _, err = bt_manip("robot", *arguments)
    assert code == 2 and message in err


def test_new_says_that_an_arm_has_no_gripper(bt_manip, tmp_path):
    arm = ROBOTS / "six_joints.urdf"
    code, _, err = bt_manip("robot", "new", arm, "-o", tmp_path / "six.toml")
    assert code == 0
    assert err.startswith("no gripper: the model has none, and --gripper gives it one: ")
    assert "suction, " in err and err.endswith(", or a model\n")
