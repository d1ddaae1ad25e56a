"""Observations have their declared form, and images the right content."""

import mujoco
import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.cell.objects import ModelObject
from bt_manip.spatial import pose
from bt_manip_learn.agents import Images, Observations


@pytest.fixture(scope="module")
def station(parts):
    station = build_station(parts)
    cell = station.cell
    T_wo = pose((0.3, 0.1, cell.surface_height("table") + 0.025), (0.8, 0.0, 0.0, 0.6))
    cell.add(station.models.create("cube"), T_wo)
    cell.step(200)
    return station


def test_numbers_are_those_of_robot_and_objects(station):
    observations = Observations(station.cell, station.robots)
    found = observations.read()
    assert found.keys() == observations.specs.keys()
    for name, (shape, dtype, _, _) in observations.specs.items():
        assert found[name].shape == shape and found[name].dtype == dtype
    groups = {name: one.group for name, one in observations.specs.items()}
    assert {groups[name] for name in found if name.startswith("robot_")} == {"robot"}
    assert {groups[name] for name in found if not name.startswith("robot_")} == {"simulator"}
    assert found["robot_joint_positions"] == pytest.approx(station.robot.q, abs=1e-6)
    assert found["robot_gripper_opening"] == pytest.approx(1.0, abs=1e-3)
    assert found["cube_position"] == pytest.approx(station.cell.pose("cube").translation, abs=1e-6)
    weight = station.cell.nominal("cube", "mass") * 9.81
    assert found["cube_contact_wrench"][2] == pytest.approx(weight, rel=0.01)
    cell, turned = station.cell, pose((0, 0, 0), (0.8, 0, 0, 0.6)).rotation
    assert found["cube_rotation"] == pytest.approx(turned.T.ravel()[:6], abs=1e-3)
    cell.data.qvel[:] = 0.1 * np.arange(1, len(cell.data.qvel) + 1)
    station.robot.gripper.set_opening(cell.data.qpos, 0.3)
    mujoco.mj_forward(cell.model, cell.data)
    found, tool = observations.read(), station.robot.tool_pose
    linear, angular = np.split(cell.data.joint("cube/").qvel, 2)
    assert found["cube_velocity"] == pytest.approx([*linear, *turned @ angular], abs=1e-2)
    assert found["robot_joint_velocities"] == pytest.approx(station.robot.v, abs=1e-6)
    assert found["robot_gripper_opening"] == pytest.approx(0.3, abs=1e-3)
    assert found["robot_tool_position"] == pytest.approx(tool.translation, abs=1e-6)
    assert found["robot_tool_rotation"] == pytest.approx(tool.rotation.T.ravel()[:6], abs=1e-6)


def test_images_show_the_entities(station, opengl):
    images = Images(("rgb", "depth", "segmentation"), width=160, height=120)
    observations = Observations(station.cell, station.robots, images)
    found = observations.read()
    groups = [observations.specs[f"overview_{kind}"].group for kind in images.kinds]
    assert groups == ["robot", "robot", "simulator"]
    observations.close()
    assert found["overview_rgb"].shape == (120, 160, 3) and found["overview_rgb"].std() > 10.0
    numbers = {name: i for i, name in enumerate(observations.entities)}
    seen = found["overview_segmentation"]
    assert {numbers["cube"], numbers["table"], numbers["panda"]} <= set(np.unique(seen).tolist())
    away = found["overview_depth"] > 20.0  # nothing is there
    assert away.sum() > 1000 and not seen[away].any()
    cell, camera = station.cell, station.cell.model.camera("overview").id
    axis = cell.data.cam_xmat[camera].reshape(3, 3)[:, 2]
    depth = -axis @ (cell.pose("cube").translation - cell.data.cam_xpos[camera])
    measured = found["overview_depth"][seen == numbers["cube"]]
    assert np.median(measured) == pytest.approx(depth, abs=0.03)


def test_joints_of_objects_are_observed(parts, tmp_path):
    file = tmp_path / "lid.xml"
    file.write_text(
        "<mujoco><worldbody><body name='lid'><joint name='slide' type='slide' axis='0 0 1'/>"
        "<geom type='box' size='0.05 0.05 0.01'/></body></worldbody></mujoco>"
    )
    station = build_station(parts)
    cell = station.cell
    name = cell.add(ModelObject(str(file)), pose((0.3, 0.4, 1.2)), name="lid", free=False)
    observations = Observations(station.cell, station.robots)
    assert observations.specs[f"{name}_joint_positions"].shape == (1,)
    cell.data.joint("lid/slide").qpos[0] = 0.02
    assert observations.read()["lid_joint_positions"] == pytest.approx([0.02])
