"""A cell with an arm among obstacles."""

from collections.abc import Sequence

import mujoco
import numpy as np
from dm_control import composer, mjcf

from bt_manip import spatial
from bt_manip.cell import Cell, objects
from bt_manip.collision import CollisionWorld
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, RobotDescription, panda
from tests.robot_fixtures import Box


def stone(rng: np.random.Generator) -> composer.Entity:
    """Return a convex mesh with 40 vertices, its origin at the centre."""
    corners = rng.normal(size=(40, 3))
    corners *= 0.08 / np.linalg.norm(corners, axis=1, keepdims=True)
    root = mjcf.RootElement(model="stone")
    root.asset.add("mesh", name="hull", vertex=corners.ravel().tolist())
    root.worldbody.add("geom", name="hull", type="mesh", mesh="hull")
    return composer.ModelWrapperEntity(root)


def arm_among_obstacles(
    rng: np.random.Generator, *, holding: bool = False, arm: RobotDescription | None = None
) -> tuple[CollisionWorld, Cell]:
    """Return an arm among boxes, meshes and a cube, with or without a held cube."""
    cell, robot = Cell(), Robot(arm or panda(), gripper=TwoFingerGripper)
    cell.add(robot, spatial.pose((0.0, 0.0, 0.3)), free=False)
    robot.set_configuration(np.array(robot.description.home))
    if arm is None:
        robot.mj_data.qpos[robot.gripper.mechanism.qpos_adr] = 0.025 - 1e-4
    mujoco.mj_forward(cell.model, cell.data)
    obstacles: Sequence[composer.Entity] = (
        Box((0.3, 0.2, 0.3)), Box((0.1, 0.5, 0.02)), stone(rng), objects.Cube(), stone(rng)
    )  # fmt: skip
    with cell.editing():
        for i, obstacle in enumerate(obstacles):
            angle = -2.0 + i
            at = (0.6 * np.cos(angle), 0.6 * np.sin(angle), rng.uniform(0.1, 0.6))
            pose = spatial.pose(at, rng.normal(size=4))
            cell.add(obstacle, pose, name=f"obstacle_{i}", free=False, overlap=np.inf)
        if holding:
            T_to = spatial.pose((0.0, 0.0, 0.015))
            cell.add(objects.Cube(), robot.tool_pose * T_to, name="held")
    return CollisionWorld(robot, robot.make_model()), cell
