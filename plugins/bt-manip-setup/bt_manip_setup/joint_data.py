"""Conservative joint limits in place of those that a model does not have."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.models import read_xml
from bt_manip.robots import Payload, RobotModel, effort_limit

# Below those of commercial arms; full acceleration is reached in 20 ms.
_HINGE = (1.5, 5.0, 250.0)  # [rad/s], [rad/s2], [rad/s3]
_SLIDE = (0.5, 2.0, 100.0)  # [m/s], [m/s2], [m/s3]
_EFFORT_MARGIN = 1.5  # ratio of an estimated effort limit to the largest required effort
_EFFORT_SHARE = 0.05  # least estimated limit, as a share of that of the strongest joint
_PAYLOAD_SHARE = 0.1  # of the arm's mass, carried at the tool
_LIGHT = 1e-4  # [kg m2 / N m] least ratio of joint inertia to effort limit; usual: 1e-3
_ARMATURE_PER_EFFORT = 1e-3  # [kg m2 / N m] ratio of armature to effort limit of light joints
_EFFORT_SAMPLES = 200  # configurations in which the required efforts are computed


class JointData(NamedTuple):
    """Limits of the joints of an arm, and their origin."""

    velocity: tuple[float, ...]  # [rad/s] or [m/s]
    acceleration: tuple[float, ...]  # [rad/s2] or [m/s2]
    jerk: tuple[float, ...]  # [rad/s3] or [m/s3]
    effort: tuple[float | None, ...]  # [N m] or [N]; None where the model has none
    velocity_known: bool
    """Whether the velocity limits are those of the model file."""


def joint_data(model: mujoco.MjModel, joints: tuple[int, ...], file: Path) -> JointData:
    """Return the limits of joints in a model and its file, conservative ones where it has none.

    URDF has velocity limits, MJCF does not.
    """
    slide = int(mujoco.mjtJoint.mjJNT_SLIDE)
    chosen = [_SLIDE if int(model.jnt_type[j]) == slide else _HINGE for j in joints]
    velocity, acceleration, jerk = zip(*chosen, strict=True)
    given = _urdf_velocities(file)
    found = tuple(given.get(model.joint(j).name, 0.0) for j in joints)
    bounds = [effort_limit(model, j) for j in joints]
    effort = tuple(bound if np.isfinite(bound) else None for bound in bounds)
    known = min(found) > 0.0
    return JointData(found if known else velocity, acceleration, jerk, effort, known)


def estimate_efforts(model: RobotModel) -> tuple[float, ...]:
    """Return effort limits that let an arm hold and accelerate itself and a payload [N m]."""
    # (nv,)
    rng, limits = np.random.default_rng(0), model.limits
    model = model.with_payload(Payload(_PAYLOAD_SHARE * pin.computeTotalMass(model.model)))
    lower, upper = limits.sampling_bounds()
    most = np.zeros(model.nq)
    for _ in range(_EFFORT_SAMPLES):
        sign = rng.choice((-1.0, 1.0), (2, model.nq))
        q = rng.uniform(lower, upper)
        tau = model.effort(q, sign[0] * limits.velocity, sign[1] * limits.acceleration)
        most = np.maximum(most, np.abs(tau))
    most = _EFFORT_MARGIN * np.maximum(most, _EFFORT_SHARE * most.max())
    return tuple(_rounded_up(float(tau)) for tau in most)


def light_joints(model: RobotModel) -> np.ndarray:
    """Return a mask of the joints with too little inertia at home for precise feedback."""
    # (nv,)
    inverse = np.linalg.inv(pin.crba(model.model, model.data, model.home))
    return np.array(1.0 / np.diagonal(inverse) < _LIGHT * model.limits.effort)


def chosen_armature(model: RobotModel, known: np.ndarray) -> tuple[float, ...] | None:
    """Return armatures with which feedback holds all joints; None if the ``known`` ones do [kg m2].

    A joint that is too light gets 1e-3 kg m2 per N m of its effort limit, as geared motors of arms
    have; the limit counts up to ten times the effort that the arm requires.
    """
    light = light_joints(model)
    if not light.any():
        return None
    effort = np.minimum(model.limits.effort, 10.0 * np.array(estimate_efforts(model)))
    chosen = np.where(light, np.maximum(_ARMATURE_PER_EFFORT * effort, known), known)
    return tuple(
        float(f"{armature:.2g}") if one else float(armature)
        for armature, one in zip(chosen, light, strict=True)
    )


def _rounded_up(value: float) -> float:
    """Round a positive number up to two digits."""
    digit = 10.0 ** (np.floor(np.log10(max(value, 1e-6))) - 1)
    return float(f"{np.ceil(value / digit - 1e-9) * digit:.2g}")


def _urdf_velocities(file: Path) -> Mapping[str, float]:
    root = read_xml(file)
    joints = root.iter("joint") if root.tag == "robot" else ()
    limits = [(joint.get("name", ""), joint.find("limit")) for joint in joints]
    return {
        name: float(limit.get("velocity"))
        for name, limit in limits  # those of transmissions have none
        if limit is not None and limit.get("velocity")
    }
