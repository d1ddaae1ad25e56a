"""Objects bring their grasps: by their class, or by sites of their model."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import build_station
from bt_manip.behaviours import Grasp, Hover, Lift, Reach
from bt_manip.bt import NodeStatus, Sequence
from bt_manip.cell import Cell
from bt_manip.cell.objects import DeclaredGrasp, ModelObject, Mug
from bt_manip.exceptions import MotionError
from bt_manip.grasping.grasp_planner import declared_grasps
from bt_manip.grippers.two_finger.declared_grasps import DeclaredGraspGenerator
from bt_manip.plugins import PluginSelection, load_plugins
from bt_manip.spatial import pose
from tests.grippers.shapes import DOWN, HAND

PLUGIN = PluginSelection(folders=(Path(__file__).with_name("plugin"),))
RIM = """<mujoco><worldbody><body name="cup">
<geom type="box" size="0.03 0.03 0.04" pos="0 0 0.04"/>
<site name="grasp_rim" type="box" size="0.01 0.002 0.01" pos="0 0.03 0.07" zaxis="0 0 -1"/>
<site name="grasp_ball" size="0.005" pos="0 0 0.1"/><site name="lid"/>
</body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def parts():
    return load_plugins(entry_points=(), warn=pytest.fail, choice=PLUGIN).parts


@pytest.fixture(scope="module")
def built(parts):
    station = build_station(parts)
    return station, station.get_state()


@pytest.fixture
def station(built):
    station, start = built
    station.set_state(start)
    return station


def add_mug(station, parts, yaw=1.2, *, name="mug", y=0.1):
    thing = parts.objects.create("handled_mug")
    quat = (np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw))
    T_wo = pose((0.4, y, station.cell.surface_height("table")), quat)
    station.cell.add(thing, T_wo, name=name)
    station.cell.step(100)
    return thing


def test_a_mug_of_a_plugin_is_picked_by_its_handle(station, parts):
    mug = add_mug(station, parts)
    height = station.cell.pose("mug").translation[2]
    tree = Sequence(Hover(object="mug"), Reach(object="mug"), Grasp(object="mug"), Lift(height=0.1))
    assert station.run(tree).status is NodeStatus.SUCCESS, tree.tip().feedback_message
    station.cell.step(500)
    T_wo = station.cell.pose("mug")
    assert T_wo.translation[2] > height + 0.07
    assert station.gripper.held == ("mug",) and station.gripper.width == pytest.approx(
        9e-3, abs=1e-3
    )
    x, y, _ = T_wo.actInv(station.robot.tool_pose.translation)
    assert x > mug.parameters["radius"] and abs(y) < 3e-3


def test_a_gripper_that_grips_in_another_way_takes_its_own_grasps(station, parts, monkeypatch):
    add_mug(station, parts)
    candidate, _ = station.first.grasp_planner.nearest("mug", station.robot.tool_pose)
    assert candidate.width == 0.009
    monkeypatch.setattr(station.gripper, "declared_grasp_generator", lambda *arguments: None)
    add_mug(station, parts, name="other", y=-0.2)  # grasps of an unchanged cell are kept
    candidate, _ = station.first.grasp_planner.nearest("mug", station.robot.tool_pose)
    assert candidate.width != 0.009


def test_sites_of_a_model_are_grasps(tmp_path):
    (tmp_path / "cup.xml").write_text(RIM)
    cell = Cell()
    cell.add(ModelObject(str(tmp_path / "cup.xml")), pose((0.3, 0.0, 0.5)), name="cup")
    cell.add(Mug(), pose((0.6, 0.0, 0.5)), name="mug")
    rim, ball = declared_grasps(cell, "cup")
    np.testing.assert_allclose(rim.T_og.translation, [0.0, 0.03, 0.07], atol=1e-9)
    np.testing.assert_allclose(rim.T_og.rotation[:, 2], [0.0, 0.0, -1.0], atol=1e-9)
    assert (rim.width, ball.width) == pytest.approx((0.004, 0.01))
    assert declared_grasps(cell, "mug") == []


def test_declared_grasps_that_fit_and_are_not_from_below_place_the_tool_with_either_finger_first():
    down = [pin.utils.rotate("z", turn) @ np.diag([1.0, -1.0, -1.0]) for turn in (0.4, 1.1)]
    places = np.array([[0.1, 0.2, 0.3], [-0.1, 0.0, 0.2]])
    given = [(down[0], places[0], 0.03), (np.eye(3), places[0], 0.03), (down[1], places[1], 0.077),
             (down[0], places[0], 0.2), (down[1], places[1], 0.3)]  # fmt: skip
    declared = [DeclaredGrasp(pin.SE3(R, p), width) for R, p, width in given]
    hand = HAND._replace(centre=0.004, shift=0.5)
    found = DeclaredGraspGenerator("it", declared, hand, np.zeros(3)).candidates(DOWN)
    assert found.width.tolist() == [0.03, 0.03, 0.077, 0.077]
    assert found.opening == pytest.approx([0.036 / 0.08] * 2 + [1.0] * 2)  # 3 mm on both sides
    for i, grasp in enumerate(found):
        T_og, side = declared[2 * (i // 2)].T_og, 1.0 - 2.0 * (i % 2)
        shift = 0.004 + 0.5 * (found.width[i] + 0.002)  # a fixed jaw is 1 mm beside the object
        assert T_og.actInv(grasp.T_ot.translation) == pytest.approx([0.0, -side * shift, 0.0])
        assert T_og.rotation.T @ grasp.T_ot.rotation == pytest.approx(np.diag([side, side, 1.0]))
    for some, refused in (
        (declared[3:], "declares grasps of 200 mm or more, and the gripper opens 80"),
        (declared[1:2], "no grasp that approaches from above or from the side"),
    ):
        with pytest.raises(MotionError, match=refused):
            DeclaredGraspGenerator("it", some, HAND, np.zeros(3)).candidates(DOWN)
