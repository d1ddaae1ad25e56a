"""Grippers of every kind open, close, and hold a cube by friction alone."""

from functools import cache

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.cell.objects import Cube
from bt_manip.control import ComputedTorque, Hold
from bt_manip.grasping import GripperClearance
from bt_manip.grippers import TwoFingerGripper, solids_of, two_finger_gripper
from bt_manip.robots import Robot, compile_alone
from bt_manip.spatial import pose
from bt_manip_setup import describe_robot
from bt_manip_setup.finger_travel import find_fingers, measured
from bt_manip_setup.linkage import touching_links
from tests.support.arms import Post, step_until

from ..assembled_arms import write_linkage_arm
from .mechanisms import ARM, MECHANISMS, described_arm, model_of

EDGE = 0.04  # [m] of the cube
FORCE = 10.0  # [N]
HANGING = pose((0.0, 0.0, 1.5), (0.0, 1.0, 0.0, 0.0))


class Scene:
    """A robot at home, its tool pointing down and its fingers open."""

    def __init__(self, robot, place=None):
        self.robot, self.gripper = robot, robot.gripper
        self.control = control = ComputedTorque(robot)
        robot.attach(control)
        self.cell = Cell()
        self.cell.add(robot, place or pose((0.0, 0.0, 0.4)), free=False)
        control.reference = Hold(robot.q)
        mujoco.mj_forward(self.cell.model, self.cell.data)

    def grasp(self, edge):
        """Stand a cube on a post where it is gripped from above, by a planned grasp."""
        cell = self.cell
        cell.add(Cube(size=edge, mass=0.05, friction=0.8), pose((1.0, 1.0, 0.5 * edge)))
        clearance = GripperClearance(cell, self.robot, ["cube"])
        generator = self.gripper.grasp_generator(
            "cube", solids_of(cell, "cube"), clearance.geom_poses, np.zeros(3),
            np.random.default_rng(0),
        )  # fmt: skip
        down = np.array([0.0, 0.0, -1.0])
        grasps = [g for g in generator.candidates(down) if g.T_ot.rotation[:, 2] @ down > 0.999]
        T_wo = self.robot.tool_pose * grasps[0].T_ot.inverse()
        x, y, z = T_wo.translation
        cell.add(Post(0.4 * edge), pose((x, y, z - 0.5 * edge)))
        cell.move("cube", T_wo, overlap=1.0)
        mujoco.mj_forward(cell.model, cell.data)


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    """Give a function that returns the robot with a gripper, described by what was found of it."""

    @cache
    def described(kind, palm):
        file = tmp_path_factory.mktemp(kind) / "post.xml"
        file.write_text(model_of(kind).replace("<!--palm-->", palm))
        found = find_fingers(mujoco.MjModel.from_xml_path(str(file)), ARM)
        gripper = two_finger_gripper(
            joints=found.joints, fingers=found.fingers, max_force=20.0, max_speed=0.2
        )
        arm = described_arm(file, tool_frame=found.body, T_ft=found.T_bt, gripper=gripper)
        return measured(arm)

    return lambda kind, palm="": Robot(described(kind, palm), gripper=TwoFingerGripper)


@pytest.fixture
def scene(kind: str, build) -> Scene:
    return Scene(build(kind), HANGING)


@pytest.mark.parametrize("kind", MECHANISMS)
def test_it_closes_on_nothing_opens_grips_with_the_asked_force_and_holds(kind, scene):
    gripper, cell = scene.gripper, scene.cell
    assert gripper.is_open
    gripper.close(FORCE)
    step_until(scene.cell, lambda: gripper.closed_on_nothing, 3.0)
    cell.step(300)
    assert gripper.closed_on_nothing and not gripper.moving and not gripper.steady
    # Where no finger stops the other, the motor presses against the joint's soft limit.
    assert gripper.width == pytest.approx(MECHANISMS[kind].closed, abs=4e-3)
    gripper.open()
    step_until(scene.cell, lambda: gripper.is_open, 3.0)
    assert gripper.width == pytest.approx(MECHANISMS[kind].opened, rel=0.05)
    scene.grasp(EDGE if MECHANISMS[kind].opened > 0.05 else 0.03)
    assert not gripper.held
    gripper.close(FORCE)
    forces = []
    step_until(cell, lambda: forces.append(max(gripper.forces)) or gripper.steady, 3.0)
    assert max(forces) < 2.5 * FORCE
    assert gripper.held == ("cube",) and not gripper.closed_on_nothing
    cell.remove("post")
    cell.step(300)
    before = cell.pose("cube").translation
    cell.step(500)
    assert np.linalg.norm(cell.pose("cube").translation - before) < 1e-3
    assert gripper.steady and gripper.held == ("cube",)
    if MECHANISMS[kind].one_moves:  # the jaws are not parallel
        assert min(gripper.forces) == pytest.approx(FORCE, rel=0.03)
    else:
        assert np.mean(gripper.forces) == pytest.approx(FORCE, rel=0.02)
    gripper.open()
    step_until(scene.cell, lambda: gripper.is_open and gripper.is_free, 3.0)


@pytest.mark.parametrize("kind", ["one_jaw"])
def test_a_state_goes_on_bit_for_bit(kind, scene):
    scene.grasp(0.03)
    gripper, cell = scene.gripper, scene.cell
    gripper.close(FORCE)
    cell.step(300)
    parts = (gripper, scene.control)
    snapshot, states = cell.snapshot(), [part.get_state() for part in parts]
    cell.step(200)
    first = cell.data.qpos.copy()
    cell.restore(snapshot)
    for part, state in zip(parts, states, strict=True):
        part.set_state(state)
    cell.step(200)
    assert np.array_equal(first, cell.data.qpos)


@pytest.mark.parametrize("kind", ["springs"])
def test_springs_do_not_change_the_opening(kind, scene):
    gripper = scene.gripper
    gripper.move(0.07)
    step_until(scene.cell, lambda: not gripper.moving, 3.0)
    scene.cell.step(200)
    assert gripper.width == pytest.approx(0.07, abs=2e-4)


@pytest.mark.parametrize(("gap", "pairs"), [(9e-4, [("left", "lever")]), (1.1e-3, [])])
@pytest.mark.parametrize(("face", "side"), [(0.052, 1), (0.006, -1)])  # outer, open; inner, closed
def test_links_touch_within_1_mm_at_any_opening(build, face, side, gap, pairs):
    """A lever is beside the left finger."""
    y = face + side * (gap + 0.002)
    shape = f'<geom type="box" size="0.004 0.002 0.02" pos="0 {y} 0.07"/>'
    robot = build("slides", f'<body name="lever"><joint name="lever" axis="0 0 1"/>{shape}</body>')
    compile_alone(robot)
    assert touching_links(robot) == pairs


def test_links_that_mimic_a_joint_neither_obstruct_each_other_nor_yield_to_the_grip(
    parts, tmp_path
):
    """They have little inertia, and URDF has no stiffness of the coupling."""
    draft = describe_robot(str(write_linkage_arm(tmp_path)), parts, name="arm")
    excluded = {frozenset(pair) for pair in draft.description.exclude}
    assert {frozenset((f"{s}_inner", f"{s}_finger")) for s in ("left", "right")} <= excluded
    assert frozenset(("left_finger", "right_finger")) not in excluded
    scene = Scene(Robot(draft.description, gripper=TwoFingerGripper))
    scene.grasp(EDGE)
    scene.gripper.close(2 * FORCE)
    step_until(scene.cell, lambda: scene.gripper.steady, 3.0)
    assert scene.gripper.width == pytest.approx(EDGE, abs=1e-3)
