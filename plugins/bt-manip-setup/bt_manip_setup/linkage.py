"""Contacts of a gripper's links with each other that hinder its fingers."""

import copy

import mujoco
import numpy as np

from bt_manip.cell import literal_name
from bt_manip.robots import Robot

from .finger_travel.bench import ancestors

_NEAR = 1e-3  # [m] distance of links that may touch when the mechanism bends under a grip
_OPENINGS = 21  # examined openings, from closed to open


def touching_links(robot: Robot) -> list[tuple[str, str]]:
    """Return the pairs of a gripper's links that touch at some opening, except its two fingers.

    Links are the bodies from the arm's last link on. As their makers built them they do not
    obstruct each other, but shapes that stand for them in a model do, such as convex hulls.

    Args:
        robot: The robot, compiled alone, with a gripper of two fingers.

    Returns:
        Names in `RobotDescription.exclude`.
    """
    assert robot.gripper is not None
    model, last = copy.copy(robot.mj_model), robot.arm_joints[-1].parent
    model.geom_margin[:] = 0.5 * _NEAR  # of both geoms together
    base, prefix = model.body(last.full_identifier).id, robot.mjcf_model.full_identifier
    names = {
        body: literal_name(model.body(body).name.removeprefix(prefix))
        for body in range(model.nbody)
        if base in ancestors(model, body)
    }
    data, found, fingers = mujoco.MjData(model), set(), set(robot.gripper.contact_body_ids)
    data.qpos[:] = robot.mj_data.qpos
    for share in np.linspace(0.0, 1.0, _OPENINGS):
        robot.gripper.set_opening(data.qpos, float(share))
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        bodies = model.geom_bodyid[data.contact.geom].reshape(-1, 2)
        found |= {tuple(sorted(pair)) for pair in bodies.tolist() if {*pair} != fingers}
    return sorted({(names[a], names[b]) for a, b in found if names.keys() >= {a, b}})
