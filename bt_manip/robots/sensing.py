"""What a robot feels: how its tool moves, and what pulls at its wrist."""

from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin


class WristWrench(NamedTuple):
    """What the arm exerts on all that is beyond its wrist."""

    force: np.ndarray  # (3,) [N]
    torque: np.ndarray  # (3,) [N m]


def wrist_of(model: mujoco.MjModel, site: int, joints: list[int]) -> int:
    """Find the body that is mounted on the last link, where a wrist sensor would sit.

    The last link itself, where nothing is mounted on it as a body of its own.

    Args:
        model: The compiled model.
        site: The tool.
        joints: The arm's joints.
    """
    links = {int(body) for body in model.jnt_bodyid[joints]}
    body = int(model.site_bodyid[site])
    mounted = body
    while body and body not in links:
        mounted, body = body, int(model.body_parentid[body])
    return mounted


def wrist_wrench(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, frame: pin.SE3
) -> WristWrench:
    """Give the wrench that a body's parent exerts on it.

    MuJoCo computes the forces between bodies only when somebody asks, as here: a force sensor in
    the model would make it do so in every step.

    Args:
        model: The compiled model.
        data: Its data after a step or ``mj_forward``.
        body: The body.
        frame: The wrench is taken about its origin, along its axes.
    """
    mujoco.mj_rnePostConstraint(model, data)
    # cfrc_int: torque over force, along the world's axes, about the centre of mass of the tree.
    torque, force = data.cfrc_int[body, :3].copy(), data.cfrc_int[body, 3:].copy()
    centre = data.subtree_com[model.body_rootid[body]]
    torque += np.cross(centre - frame.translation, force)
    return WristWrench(frame.rotation.T @ force, frame.rotation.T @ torque)


def tool_velocity(model: mujoco.MjModel, data: mujoco.MjData, site: int) -> np.ndarray:
    """Give a site's velocity: linear, then angular, both in the world."""  # (6,) [m/s, rad/s]
    velocity = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
    return np.concatenate([velocity[3:], velocity[:3]])
