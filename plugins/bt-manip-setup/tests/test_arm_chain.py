import mujoco
import pytest

from bt_manip.robots import RobotError
from bt_manip_setup.arm_chain import find_arm, find_mount

SHAPE = '<geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.02"/>'
FINGER = '<geom type="box" size="0.005 0.01 0.02" pos="0 0 0.02"/>'
FINGERS = f"""
<body name="one" pos="0.02 0 0.2"><joint name="a" type="slide" axis="1 0 0"/>{FINGER}</body>
<body name="two" pos="-0.02 0 0.2"><joint name="b" type="slide" axis="1 0 0"/>{FINGER}</body>
"""
RAIL = '<joint name="x" type="slide" axis="1 0 0"/>'


def chain(names, end="", prefix="link"):
    """Return links of 0.2 m, one above the other, with hinges of alternating axes."""
    text = end
    for i, name in reversed(list(enumerate(names))):
        axis = "0 0 1" if i % 2 == 0 else "0 1 0"
        joint = f'<joint name="{name}" axis="{axis}" range="-2 2" limited="true"/>'
        text = f'<body name="{prefix}{i}" pos="0 0 {0.2 * (i > 0)}">{joint}{SHAPE}{text}</body>'
    return text


def compiled(*bodies):
    xml = "".join(bodies)
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><worldbody>{xml}</worldbody></mujoco>'
    )


def names(model, joints):
    return [model.joint(j).name for j in joints]


@pytest.mark.parametrize(
    ("body", "joints", "fingers", "flange"),
    [
        (chain("pqrs", '<body name="plate"/>'), "pqrs", "", ["link3", "plate"]),
        (chain("pqr", f'<body name="palm">{FINGERS}</body>'), "pqr", "ab", ["link2", "palm"]),
        (f'<body name="cart">{RAIL}{SHAPE}{chain("pqr")}</body>', "xpqr", "", ["link2"]),
    ],
    ids=["without a gripper", "with fingers", "on a rail"],
)
def test_an_arm_is_the_longest_chain_without_fingers(body, joints, fingers, flange):
    model = compiled(body)
    arm = find_arm(model)
    assert names(model, arm.joints) == [*joints] and names(model, arm.fingers) == [*fingers]
    assert [model.body(b).name for b in arm.flange] == flange


@pytest.mark.parametrize(
    ("gap", "travel", "jaw"),
    [(1.9, 18.2, "h"), (1.9, 18.0, ""), (2.1, 40.0, ""), (-1.0, 30.0, "h")],
)
def test_a_jaw_that_closes_against_the_last_link_and_opens_by_20_mm_is_a_finger(gap, travel, jaw):
    fixed = '<geom type="box" size="0.005 0.01 0.03" pos="-0.02 0 0.26" contype="0"/>'
    at, shell = f'pos="{1e-3 * gap - 0.01} 0 0.06"', 'contype="0" conaffinity="0"'
    moving = f'<geom type="box" size="0.005 0.01 0.03" {at}/><geom size="0.006" {at} {shell}/>'
    joint = f'<joint name="h" type="slide" axis="1 0 0" range="0 {1e-3 * travel}" limited="true"/>'
    model = compiled(chain("pqr", f'{fixed}<body name="m" pos="0 0 0.2">{joint}{moving}</body>'))
    arm = find_arm(model)
    assert names(model, arm.joints) == [*("pqr" if jaw else "pqrh")]
    assert names(model, arm.fingers) == [*jaw]


def test_of_several_arms_one_is_chosen_by_its_joints_with_names_as_they_are_typed():
    """PyMJCF writes the slash of a name in another way, which nobody has to type."""
    model = compiled(
        chain(["left\\waist", "p", "q"]), chain(["right\\waist", "v", "w"], prefix="r")
    )
    with pytest.raises(
        RobotError, match="from joint 'left/waist', one from 'right/waist': .*--joints"
    ):
        find_arm(model)
    right = find_arm(model, ["right/waist", "v", "w"])
    assert names(model, right.joints) == ["right\\waist", "v", "w"]
    with pytest.raises(RobotError, match="did you mean 'left/waist'"):
        find_arm(model, ["left/wast", "p"])


@pytest.mark.parametrize(
    ("body", "joints", "message"),
    [
        (chain("pqr"), ["q"], r"at least 2 joints, got 1 \(--joints\)"),
        (f'<body name="box">{SHAPE}</body>', None, "the model has no joints"),
        (f'<body name="box"><freejoint name="loose"/>{SHAPE}</body>', None, "'loose' is free or a"),
    ],
)
def test_what_is_no_arm_is_refused(body, joints, message):
    with pytest.raises(RobotError, match=message):
        find_arm(compiled(body), joints)


def test_a_gripper_is_mounted_at_the_site_that_its_name_suggests_or_at_the_last_body():
    model = compiled(chain("pqr", '<site name="camera"/><site name="tool_flange"/>'))
    assert find_mount(model, find_arm(model)) == "tool_flange"
    with pytest.raises(RobotError, match=r"no site or body 'flang'; .*\(--mount\)"):
        find_mount(model, find_arm(model), "flang")
    model = compiled(chain("pqr", '<body name="plate"/>'))
    assert find_mount(model, find_arm(model)) == "plate"
