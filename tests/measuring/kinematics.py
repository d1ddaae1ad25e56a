"""Errors of inverse kinematics, measured by other code than its own."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.exceptions import MotionError


def frame_pose(model, q, name):
    """Return the pose of a frame by Pinocchio's forward kinematics, on data of its own."""
    data = model.model.createData()
    pin.framesForwardKinematics(model.model, data, q)
    return data.oMf[model.model.getFrameId(name)].copy()


def position_error(model, q, name, position):
    """Return the distance of a frame from a position [m]."""
    return np.linalg.norm(frame_pose(model, q, name).translation - position)


def rotation_error(model, q, name, rotation):
    """Return the angle between a frame and a rotation [rad]."""
    return np.linalg.norm(pin.log3(frame_pose(model, q, name).rotation.T @ rotation))


def error_in_mujoco(robot, q, T):
    """Return distance [m] and angle [rad] between the simulated tool and a pose."""
    robot.set_configuration(q)
    mujoco.mj_kinematics(robot.mj_model, robot.mj_data)
    found = robot.tool_pose
    angle = np.linalg.norm(pin.log3(found.rotation.T @ T.rotation))
    return np.linalg.norm(found.translation - T.translation), angle


def random_configurations(model, rng, n):
    """Return random configurations inside the limits."""  # (n, nq)
    return rng.uniform(model.limits.lower, model.limits.upper, (n, model.nq))


def differentiate(f, q, h=1e-6):
    """Return the derivative of a function of the configuration by central differences."""
    steps = h * np.eye(len(q))
    return np.stack([(f(q + d) - f(q - d)) / (2.0 * h) for d in steps], axis=-1)


def refused(make, message):
    """Assert that a call is refused as invalid input by a message of one line."""
    with pytest.raises(MotionError, match=message) as raised:
        make()
    assert raised.value.reason == "target"
    assert "\n" not in str(raised.value)
