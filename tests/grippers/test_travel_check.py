"""A measured travel is read from the description, and refused where it no longer fits."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import (
    Robot,
    RobotDescription,
    RobotError,
    compile_alone,
    panda,
    read_description,
)
from bt_manip.spatial import pose

MODELS = Path(__file__).parents[1] / "robots" / "models"
PARTS = ["bodies", "joints", "couplings", "tool frame", "keys"]


@pytest.fixture
def file(tmp_path) -> Path:
    """Give a description of a copy of two models, with their travel."""
    for name in ("post.toml", "post.xml", "pincers.xml"):
        (tmp_path / name).write_text((MODELS / name).read_text())
    return tmp_path / "post.toml"


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def make(path: Path) -> Robot:
    return Robot(read_description(path), gripper=TwoFingerGripper)


def changed_parts(path: Path) -> list[str]:
    """Return the parts that the error names, whose rest is checked."""
    with pytest.raises(RobotError) as error:
        make(path)
    found = re.fullmatch(
        rf"{path}: robot 'post': key 'gripper.travel' was measured with other (.*); "
        rf"'bt-manip robot measure {path}' measures it again",
        str(error.value),
    )
    assert found is not None, error.value
    return found[1].split(" and ")


def test_a_travel_that_fits_is_read_and_its_joints_have_the_described_friction(file):
    robot = make(file)
    travel = robot.gripper.mechanism.travel
    compile_alone(robot)
    friction = robot.mj_model.dof_frictionloss
    dofs = [robot.mj_model.joint(f"pincers/{name}").dofadr[0] for name in travel.joints]
    assert friction[dofs] == pytest.approx(0.001)
    assert not np.delete(friction, dofs).any()
    assert list(travel.digests) == PARTS
    assert travel.motor == "both" and "left_driver" in travel.joints
    assert np.shape(travel.positions) == (len(travel.joints), len(travel.widths))


@pytest.mark.parametrize(
    ("model", "old", "new", "parts"),
    [
        ("pincers.xml", 'mass="0.03"', 'mass="0.04"', ["bodies"]),
        ("pincers.xml", 'pos="0 0.02 0.03"', 'pos="0 0.021 0.03"', ["bodies"]),
        ("pincers.xml", 'damping="0.02"', 'damping="0.03"', ["joints"]),
        ("pincers.xml", "-0.411517 0.643501", "-0.4 0.643501", ["joints"]),
        ("pincers.xml", 'polycoef="0 -1 0 0 0"', 'polycoef="0 -1.1 0 0 0"', ["couplings"]),
        ("post.toml", "[0.0, 0.0, 0.11]", "[0.0, 0.0, 0.111]", ["tool frame"]),
        ("post.toml", "frictionloss = 0.001", "frictionloss = 0.002", ["keys"]),
        ("post.toml", 'motor = "both"\nopen_width = 0.1', "open_width = 0.1", ["keys"]),
    ],
)
def test_a_change_of_what_was_measured_is_named_with_the_remedy(file, model, old, new, parts):
    change(file.parent / model, old, new)
    assert changed_parts(file) == parts


def test_other_changes_are_none_of_the_travel(file):
    for model, old, new in (
        ("pincers.xml", 'friction="0.3"', 'friction="0.3" rgba="1 0 0 1"'),
        ("pincers.xml", '<geom class="crank"/>', "<geom class='crank' /><!-- a crank -->"),
        ("post.toml", "max_force = 40.0", "max_force = 30.0"),
        ("post.toml", "open_width = 0.1\n", "open_width = 0.09\n"),
        ("post.toml", "position = [0.0, 0.0, 0.2]", "position = [0.3, 0.0, 0.2]"),
        ("post.toml", "position = [0.0, 0.0, 0.01]", "position = [0.0, 0.0, 0.02]"),
        ("post.toml", "velocity = [1.0, 2.0]", "armature = 0.5\nvelocity = [1.0, 2.0]"),
    ):
        change(file.parent / model, old, new)
    make(file)


def test_a_missing_travel_is_named_with_the_remedy(file):
    file.write_text(file.read_text().partition("# Measured")[0])
    with pytest.raises(RobotError) as error:
        make(file)
    assert str(error.value) == (
        f"{file}: robot 'post': key 'gripper.travel' is missing: 'bt-manip robot measure {file}' "
        "measures the fingers' travel"
    )


@pytest.mark.parametrize(("force", "limit"), [(20.0, 20.0), (500.0, 140.0)])
def test_motors_of_slides_have_the_smaller_limit_of_model_and_description(force, limit):
    gripper = replace(panda().gripper, max_force=force)
    robot = Robot(replace(panda(), gripper=gripper), gripper=TwoFingerGripper)
    compile_alone(robot)
    for motor in robot.gripper.mechanism.actuators:
        found = robot.mj_model.actuator(motor.full_identifier).ctrlrange
        assert found.tolist() == [-limit, limit]


def test_motors_need_the_largest_effort_along_the_travel_and_a_fifth_more(file):
    parts = replace(
        make(file).gripper.mechanism.travel,
        motor=None,
        joints=("a", "b"),
        ratios=(1.0, -2.0),
        polynomials=((0.01, 0.2, -0.5), (0.0, -0.3)),
        holding=((0.1, 0.4), (-0.2,)),
        widths=(0.0, 0.05, 0.1),
        positions=((0.0, 0.1, 0.3), (0.0, -0.1, -0.2)),
    )
    # ds/dq is 0.2 - q and -0.3; springs take 0.1 + 0.4 q and 0.2.
    expected = [1.2 * 20.0 * 0.2 + 0.22, 1.2 * 20.0 * 0.6 + 0.2]
    assert parts.efforts(20.0, ("a", "b")) == pytest.approx(expected)
    together = replace(parts, motor="m").efforts(20.0, ("a", "b"))
    assert together == pytest.approx([sum(expected) - 0.2])
    assert parts.configuration(0.025) == pytest.approx([0.05, -0.05])
    assert parts.configuration(0.075) == pytest.approx([0.2, -0.15])


def in_python(**parameters: object) -> RobotDescription:
    gripper = panda().gripper
    assert gripper is not None
    return replace(panda(), gripper=replace(gripper, parameters=gripper.parameters | parameters))


def test_the_openings_of_the_description_limit_those_of_the_model(file):
    def openings(**given):
        travel = Robot(in_python(**given), gripper=TwoFingerGripper).gripper.mechanism.travel
        return pytest.approx((travel.min_width, travel.open_width))

    assert openings(min_width=0.02, open_width=0.07) == (0.02, 0.07)
    assert openings(open_width=0.0819) == (0.0, 0.08)  # 2 mm of tolerance
    for width, message in ((0.0821, "82.1 mm, but .* open to 80.0"), (0.0519, "close to 50.0 mm")):
        with pytest.raises(RobotError, match=message):
            openings(min_width=0.05, open_width=width)
    change(file, "min_width = 0.0", "min_width = 0.01")
    assert make(file).gripper.mechanism.travel.min_width == 0.01


def test_a_description_in_python_names_the_file_of_its_travel(tmp_path):
    file = tmp_path / "travel.toml"
    missing = rf"'gripper.travel' is missing \(no file {file}\): 'bt-manip robot measure panda'"
    with pytest.raises(RobotError, match=missing):
        Robot(in_python(travel=str(file)), gripper=TwoFingerGripper)
    other = replace(panda(), T_ft=pose((0.0, 0.0, 0.01)))
    with pytest.raises(RobotError, match="with other tool frame; 'bt-manip robot measure panda'"):
        Robot(other, gripper=TwoFingerGripper)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mass = ", "mas = ", "key 'gripper.travel.mass' is missing"),
        ("widths = [", "widths = [0.0, ", "'gripper.travel' has 'positions' that do not fit"),
        ("holding = [[", "holding = [[\"a\", ", "'gripper.travel.holding' is a list of lists"),
        ("holding = [[", "holding = [[], [", "'gripper.travel.holding' is a list of lists"),
        ("holding = [[", "holding = [5, [", "'gripper.travel.holding' is a list of lists"),
    ],
)  # fmt: skip
def test_a_damaged_travel_is_refused(file, old, new, message):
    change(file, old, new)
    with pytest.raises(RobotError, match=message):
        make(file)
