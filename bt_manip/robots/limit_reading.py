"""The limits of an arm, from its model and its description together."""

import mujoco
import numpy as np

from .errors import RobotError
from .joint_limits import JointLimits
from .model_building import find
from .robot_description import RobotDescription


def read_limits(mj_model: mujoco.MjModel, description: RobotDescription) -> JointLimits:
    """Join what the model and the description say of the arm's joints.

    Positions come from the model. Efforts come from the description, or from the model: the
    tightest of the joints' and the actuators' force ranges, and of what a motor's control range
    lets through.

    Args:
        mj_model: The robot's own model, compiled alone.
        description: What else is known of it.

    Raises:
        RobotError: When a joint is unknown or its effort is not bounded anywhere.
    """
    kind = int(mujoco.mjtObj.mjOBJ_JOINT)
    joints = [find(mj_model, kind, name) for name in description.arm_joints]
    limited = mj_model.jnt_limited[joints].astype(bool)
    effort = description.effort
    if effort is None:
        effort = tuple(effort_limit(mj_model, joint) for joint in joints)
        unbounded = [
            name
            for name, bound in zip(description.arm_joints, effort, strict=True)
            if not np.isfinite(bound)
        ]
        if unbounded:
            raise RobotError(
                f"robot '{description.name}': neither its model nor its description bounds the "
                f"effort of {', '.join(unbounded)}; give `effort` in the description"
            )
    return JointLimits(
        lower=np.where(limited, mj_model.jnt_range[joints, 0], -np.inf),
        upper=np.where(limited, mj_model.jnt_range[joints, 1], np.inf),
        velocity=np.array(description.velocity),
        acceleration=np.array(description.acceleration),
        jerk=np.array(description.jerk),
        effort=np.array(effort),
    )


def effort_limit(mj_model: mujoco.MjModel, joint: int) -> float:
    """Give the effort that a joint's actuators can make at the most, infinite when unbounded."""
    bound = np.inf
    if mj_model.jnt_actfrclimited[joint]:
        bound = float(np.abs(mj_model.jnt_actfrcrange[joint]).min())
    on_joint = mj_model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
    for i in np.flatnonzero(on_joint & (mj_model.actuator_trnid[:, 0] == joint)):
        gear = abs(float(mj_model.actuator_gear[i, 0]))
        if mj_model.actuator_forcelimited[i]:
            bound = min(bound, gear * float(np.abs(mj_model.actuator_forcerange[i]).min()))
        if mj_model.actuator_ctrllimited[i] and is_motor(mj_model, int(i)):
            bound = min(bound, gear * float(np.abs(mj_model.actuator_ctrlrange[i]).min()))
    return bound


def is_motor(mj_model: mujoco.MjModel, actuator: int) -> bool:
    """Tell whether an actuator's force is its control signal and nothing else."""
    return (
        int(mj_model.actuator_gaintype[actuator]) == int(mujoco.mjtGain.mjGAIN_FIXED)
        and int(mj_model.actuator_biastype[actuator]) == int(mujoco.mjtBias.mjBIAS_NONE)
        and int(mj_model.actuator_dyntype[actuator]) == int(mujoco.mjtDyn.mjDYN_NONE)
        and float(mj_model.actuator_gainprm[actuator, 0]) == 1.0
    )
