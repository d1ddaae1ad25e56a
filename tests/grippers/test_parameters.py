"""What a description says of a gripper of two fingers, and what is said of what it may not."""

import pytest

from bt_manip.grippers import two_finger_gripper
from bt_manip.grippers.two_finger.parameters import read_parameters
from bt_manip.robots import RobotError, read_description
from tests.robot_fixtures import GRIPPER, LEAST

ARM = LEAST + GRIPPER.lstrip()


@pytest.fixture
def read(tmp_path):
    def go(text):
        path = tmp_path / "arm.toml"
        path.write_text(text)
        return read_description(path).gripper

    return go


def test_a_file_and_python_say_the_same(read):
    described = two_finger_gripper(
        joints=("left", "right"), fingers=("one", "two"), open_width=0.08, max_speed=0.1,
        max_force=20, pads={"solref": (0.004, 1.0)},
    )  # fmt: skip
    from_file = read(ARM + "[gripper.pads]\nsolref = [0.004, 1.0]\n")
    assert from_file == described
    parameters = read_parameters(from_file.read("arm"))
    assert parameters.joints == ("left", "right") and parameters.min_width == 0.0
    assert parameters.pads.solref == (0.004, 1.0) and parameters.pads.solimp is None
    assert parameters == read_parameters(described.read("arm"))


def test_one_joint_is_enough_and_the_openings_may_be_left_to_the_model(read):
    text = ARM.replace('"left", "right"', '"left"').replace("open_width = 0.08\n", "")
    parameters = read_parameters(read(text).read("arm"))
    assert parameters.joints == ("left",) and parameters.open_width is None


JOINTS, FINGERS = '"left", "right"', '"one", "two"'
ONE_OR_TWO = "'gripper.joints' is a list of 1 to 2 names, each once, got"
TWO = "'gripper.fingers' is a list of 2 names, each once, got"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            ARM + "max_forze = 3\n",
            "arm.toml:16: key 'gripper.max_forze' means nothing; did you mean 'max_force'",
        ),
        (ARM.replace(JOINTS, ""), f"{ONE_OR_TWO} none"),
        (ARM.replace(JOINTS, '"left", "left"'), f"{ONE_OR_TWO} left, left"),
        (ARM.replace(FINGERS, '"one"'), f"{TWO} one"),
        (ARM + "[gripper.pads]\nsolrf = [0.01]\n", "'gripper.pads.solrf' means nothing"),
    ],
)
def test_what_is_wrong_is_said_with_its_file_and_key_or_with_its_robot(read, text, message):
    with pytest.raises(RobotError, match=message):
        read_parameters(read(text).read("arm"))
    wrong = two_finger_gripper(
        joints=(), fingers=("a", "b"), open_width=0.1, max_speed=1.0, max_force=1.0
    )
    with pytest.raises(RobotError, match=f"robot 'arm': key {ONE_OR_TWO}"):
        read_parameters(wrong.read("arm"))
