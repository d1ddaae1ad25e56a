"""Comparison of the Pinocchio model against the simulated MuJoCo model."""

from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.robots import sampling_bounds


class Verification(NamedTuple):
    """The largest differences between two models of one robot, in absolute terms.

    Attributes:
        mass_error: Of the elements of M(q) [kg m2].
        bias_error: Of Coriolis, centrifugal and gravity efforts [N m].
        frame_error: Of positions [m] and elements of rotation matrices of all frames.
    """

    mass_error: float
    bias_error: float
    frame_error: float

    @property
    def worst(self) -> float:
        """The largest of the errors."""
        return max(self)


def verify(
    mj_model: mujoco.MjModel,
    pin_model: pin.Model,
    *,
    rng: np.random.Generator,
    n: int = 100,
    qpos: np.ndarray | None = None,
) -> Verification:
    """Compare a Pinocchio model with MuJoCo at random configurations inside the limits.

    Args:
        mj_model: The simulated model.
        pin_model: The model of the robot that was built from it.
        rng: Random generator of configurations, and of velocities with standard deviation 1.
        n: Number of configurations.
        qpos: Positions at which the other joints are locked; default: ``mj_model.qpos0``.
    """
    joints = [mj_model.joint(name).id for name in list(pin_model.names)[1:]]
    at_q, at_v = mj_model.jnt_qposadr[joints], mj_model.jnt_dofadr[joints]
    lower, upper = sampling_bounds(pin_model.lowerPositionLimit, pin_model.upperPositionLimit)
    data, pin_data = mujoco.MjData(mj_model), pin_model.createData()
    if qpos is not None:
        data.qpos[:] = qpos
    full = np.zeros((mj_model.nv, mj_model.nv))
    worst = np.zeros(3)
    for _ in range(n):
        q, v = rng.uniform(lower, upper), rng.standard_normal(len(joints))
        data.qpos[at_q], data.qvel[at_v] = q, v
        mujoco.mj_forward(mj_model, data)
        mujoco.mj_fullM(mj_model, data, full)
        mass = pin.crba(pin_model, pin_data, q) - full[np.ix_(at_v, at_v)]
        bias = pin.nonLinearEffects(pin_model, pin_data, q, v) - data.qfrc_bias[at_v]
        pin.framesForwardKinematics(pin_model, pin_data, q)
        frames = _frame_errors(data, pin_model, pin_data)
        worst = np.maximum(worst, [np.abs(one).max(initial=0.0) for one in (mass, bias, frames)])
    return Verification(*worst.tolist())


def _frame_errors(data: mujoco.MjData, pin_model: pin.Model, pin_data: pin.Data) -> np.ndarray:
    errors = []
    find = {pin.FrameType.BODY: data.body, pin.FrameType.OP_FRAME: data.site}
    for i, frame in enumerate(pin_model.frames):
        if frame.type not in find or frame.name.startswith("#") or frame.name == "universe":
            continue
        there = find[frame.type](frame.name)
        T = pin_data.oMf[i]
        errors.append([*(T.translation - there.xpos), *(T.rotation.ravel() - there.xmat)])
    return np.array(errors)
