"""A description in a TOML file: what may be written, and what is said of what may not."""

import pinocchio as pin
import pytest

from bt_manip.robots import RobotError, Tolerance, ToolLimits, read_description, read_gripper
from tests.robot_fixtures import GRIPPER, LEAST


@pytest.fixture
def read(tmp_path):
    def go(text):
        path = tmp_path / "arm.toml"
        path.write_text(text)
        return read_description(path)

    return go


def test_little_has_to_be_said(read, tmp_path):
    arm = read(LEAST)
    assert arm.name == "arm"
    assert arm.model == str(tmp_path / "arm.xml")
    assert (arm.velocity, arm.acceleration, arm.jerk) == ((2.0, 2.0), (3.0, 3.0), (4.0, 5.5))
    assert arm.effort is None and arm.armature is None and arm.gripper is None
    assert arm.tool_limits == ToolLimits()
    assert arm.tolerance == Tolerance(position=1e-5, rotation=1e-4)
    assert arm.T_rb == arm.T_ft == pin.SE3.Identity()


def test_pairs_of_bodies_that_may_touch_are_read(read):
    assert read('exclude = [["foot", "left/link"]]\n' + LEAST).exclude == (("foot", "left/link"),)


def test_a_model_of_the_menagerie_is_looked_for_when_it_is_used(read):
    text = LEAST.replace("arm.xml", "menagerie:kuka_iiwa_14/iiwa14")
    assert read(text).model == "menagerie:kuka_iiwa_14/iiwa14"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (LEAST.replace("velocity", "velocty"), "key 'velocity' is missing.*did you mean 'velocty'"),
        (LEAST + "colour = 3\n", "key 'tool.colour' means nothing"),
        (LEAST.replace("[4, 5.5]", '"much"'), "'jerk' is a list of 2 numbers, got 'much'"),
        (LEAST.replace('["a", "b"]', '"a"'), "'arm_joints' is a list of names, got 'a'"),
        (LEAST.replace('frame = "tip"', ""), "'tool.frame' is missing: a text"),
        (LEAST.replace("[tool]", "[tol]"), "'tool' is missing: a table with the 'frame'"),
        (LEAST + "quat_wxyz = [0, 0, 0, 0]\n", "'tool.quat_wxyz' is no rotation"),
        (LEAST + GRIPPER.replace("= 20", "= true"), "'gripper.max_force' is a number, got True"),
        (LEAST + GRIPPER + 'model = "hand.xml"\n', "'gripper.mount' is missing: a text"),
        (LEAST + "[base]\npedestal = [1, 1, 0]\n", "pedestal' is a positive number .m., got 0"),
        (LEAST.replace('["a", "b"]', '["a", "a"]'), "'arm_joints' .* each once, got a, a"),
        ('exclude = ["a", "b"]\n' + LEAST, "'exclude' is a list of pairs of names.*got ..a', 'b'"),
        ('exclude = [["a", 1]]\n' + LEAST, "'exclude' is a list of pairs of names"),
        ('exclude = [["a", "a"]]\n' + LEAST, "'exclude' has pairs of two names, got 'a' twice"),
        ("model = ", "not a TOML file"),
    ],
)
def test_what_is_wrong_is_said_with_its_file_and_key(read, text, message):
    with pytest.raises(RobotError, match=message) as error:
        read(text)
    assert "arm" in str(error.value)


def test_the_gripper_is_read_from_a_file_that_is_wrong_otherwise(read, tmp_path):
    with pytest.raises(RobotError):
        read(GRIPPER)
    assert read_gripper(tmp_path / "arm.toml").max_force == 20.0


def test_a_missing_file_is_said(tmp_path):
    with pytest.raises(RobotError, match="no robot description .*nothing.toml: No such file"):
        read_description(tmp_path / "nothing.toml")


def test_all_wrong_keys_are_said_at_once_each_with_its_line(read):
    text = (
        LEAST.replace("velocity = 2", 'velocity = "fast"')
        .replace("home = [0.0, 1.0]", "home = [0.0]")
        .replace('frame = "tip"', "fram = 1\nposition = [0, 0]\nrpy = 1")
    )
    gripper = GRIPPER.replace("max_force = 20", "max_force = -1")
    with pytest.raises(RobotError) as error:
        read("speeds = 1\n" + text + gripper + "[tolerance]\nposition = 0\nrotatoin = 1\n")
    keys = [line.split("key ")[1] for line in str(error.value).splitlines()]
    assert [key.split("'")[1] for key in keys] == [
        "tool.frame", "home", "velocity", "gripper.max_force", "tolerance.position",
        "tolerance.rotatoin", "tool.position", "tool.rpy", "tool.fram", "speeds",
    ]  # fmt: skip
    assert "arm.toml:6: key 'velocity' is a list of 2 numbers, got 'fast'" in str(error.value)
