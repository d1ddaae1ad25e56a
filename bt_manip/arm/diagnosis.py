"""Reasons why an arm has stopped by itself or does not reach its target."""

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from .external_force_guard import Detection, ExternalLoad, external_load

if TYPE_CHECKING:
    from .arm import Arm

UNEXPLAINED = 0.25  # largest part of the external torque that an assumed force may leave open
UNCERTAINTY = 0.5  # of its threshold, by which an external torque is uncertain
AT_LIMIT = 1e-3  # [rad]
LOADED = 0.5  # of its threshold, from which a joint carries a part of an external force
MAX_PAYLOAD_ANGLE = 0.3  # [rad] between the force and gravity, for an unknown payload
MIN_LEVER = 0.05  # [m] at which the direction of a force can be estimated


def diagnose(arm: "Arm", found: Detection | None) -> str:
    """Return the reason of a fault.

    Args:
        arm: The arm at the time of the fault.
        found: The detected force; None where the external torques are below their thresholds.
    """
    robot, dt, timestep = arm.robot, arm.follower.dt, float(arm.robot.mj_model.opt.timestep)
    if robot.measurement_problem:
        return robot.measurement_problem
    if abs(timestep - dt) > 1e-9:
        return f"the time step has changed from {1e3 * dt:g} to {1e3 * timestep:g} ms"
    pairs = arm.world.present_contacts() if arm.world else []
    contacts = " and ".join(f"'{first}' touches '{second}'" for first, second in pairs)
    error = np.zeros(arm.model.nq) if arm.compliant else arm.q - robot.q
    joint = int(np.abs(error).argmax())
    limits = arm.model.limits  # one takes up the torque of a joint that is at it
    free = (robot.q >= limits.lower + AT_LIMIT) & (robot.q <= limits.upper - AT_LIMIT)
    if found is None or not found.following or not (found.load.exceeding & free).any():
        touching = contacts or "nothing touches the arm"
        return (
            f"the controller does not follow: joint {joint + 1} is {abs(error[joint]):.3f} rad off "
            f"its reference and {touching}"
        )
    present = external_load(robot, arm.model)
    lasting = present if present.exceeded else found.load
    details = f"{found.load}; {contacts or _describe_force(arm, lasting)}".removesuffix("; ")
    held = arm.world.held if arm.world else None
    holds = held is not None or arm.payload is not None
    touched = any(first.split("/")[0] != held for first, _ in pairs)  # not only the held object
    unknown = _unknown_payload(arm, present) if holds and not touched else 0.0
    if not unknown:
        return f"external force on the arm: {details}"
    assumed = arm.payload.mass if arm.payload else 0.0
    about = "at least" if contacts else "about"  # something else may carry a part of it
    return (
        f"the payload weighs {about} {_two_digits(assumed + unknown)} kg, "
        f"{_two_digits(assumed)} kg were assumed: {details}"
    )


def _unknown_payload(arm: "Arm", load: ExternalLoad) -> float:
    """Return the mass at the tool that explains external torques [kg]; 0 where none does."""
    robot, model = arm.robot, arm.model
    fit = _fit_force(model.jacobian(robot.q)[:3], load)
    if fit is None or fit[0] > UNEXPLAINED:
        return 0.0
    force = fit[1]
    pin.forwardKinematics(model.model, model.data, robot.q, robot.v, robot.a)
    acceleration = pin.getFrameClassicalAcceleration(
        model.model, model.data, model.tool_frame_id, pin.LOCAL_WORLD_ALIGNED
    ).linear
    fall = model.model.gravity.linear - acceleration
    along = float(force @ fall)
    if along < np.cos(MAX_PAYLOAD_ANGLE) * np.linalg.norm(force) * np.linalg.norm(fall):
        return 0.0
    return along / float(fall @ fall)


def _describe_force(arm: "Arm", load: ExternalLoad) -> str:
    """Describe the force that explains external torques; empty where it is unknown.

    A force on a link has no torque at the joints beyond it.
    """
    loaded = np.flatnonzero(np.abs(load.values) > LOADED * load.thresholds).tolist()
    if len(loaded) < 2:
        return f"only joint {loaded[0] + 1} is loaded" if loaded else ""
    points = [("the tool", arm.model.jacobian(arm.robot.q)[:3])]
    points += [(f"link {i + 1}", _link_jacobian(arm, i)) for i in range(loaded[-1], arm.model.nq)]
    fits = [(*fit, where) for where, jacobian in points if (fit := _fit_force(jacobian, load))]
    rest, force, where = min(fits, key=lambda fit: fit[0], default=(np.inf, np.zeros(3), ""))
    if rest > UNEXPLAINED:
        return f"it acts on link {loaded[-1] + 1} or beyond"
    size = float(np.linalg.norm(force))
    x, y, z = (force / size).round(2) + 0.0
    unit = "N s" if load.impact else "N"
    return f"about {_two_digits(size)} {unit} towards ({x:g}, {y:g}, {z:g}) at {where}"


def _two_digits(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}"


def _link_jacobian(arm: "Arm", joint: int) -> np.ndarray:
    """Return the Jacobian of the velocity of a link's centre of mass, in world axes."""  # (3, nv)
    model, data = arm.model.model, arm.model.data
    pin.computeJointJacobians(model, data, arm.robot.q)
    velocities = pin.getJointJacobian(model, data, joint + 1, pin.LOCAL_WORLD_ALIGNED)
    centre = data.oMi[joint + 1].rotation @ model.inertias[joint + 1].lever
    return velocities[:3] - pin.skew(centre) @ velocities[3:]


def _fit_force(jacobian: np.ndarray, load: ExternalLoad) -> tuple[float, np.ndarray] | None:
    """Fit a force at a point to external torques; None where the joints cannot tell its direction.

    Args:
        jacobian: Of the velocity of the point, in world axes.  # (3, nv)
        load: The external torques or impulses.

    Returns:
        The largest part of the torques that it leaves open, and the force [N or N s].
    """
    if np.linalg.svd(jacobian, compute_uv=False)[-1] < MIN_LEVER:
        return None
    levers, values = (jacobian / load.thresholds).T, load.values / load.thresholds
    force = np.linalg.lstsq(levers, values, rcond=None)[0]
    open_part = np.maximum(np.abs(values - levers @ force).max() - UNCERTAINTY, 0.0)
    return float(open_part / np.abs(values).max()), force
