"""Blending of two motions: the arm changes from one to the other without coming to rest."""

from itertools import product
from operator import itemgetter

import numpy as np
import pinocchio as pin

from bt_manip.collision import CollisionWorld
from bt_manip.exceptions import MotionError
from bt_manip.robots import MotionLimits, RobotModel
from bt_manip.trajectories import (
    CONTROL_STEP,
    EFFORT_FRACTION,
    BlendedTrajectory,
    JointTrajectory,
    TailTrajectory,
    Trajectory,
    effort_use,
    joint_profiles,
    sample_times,
    tool_use,
)

from .collision_check import trajectory_is_free

BLEND_LEVER = 0.2  # [m] from the tool, where a point is whose travel counts for a rotation
MAX_BLEND = 0.9  # of a motion that may be replaced by a blend
BLEND_SAMPLES = 40  # of a trajectory, at which the distance of the tool is compared
ARRIVALS = (1.0, 0.8, 0.4)  # of the part of the second motion inside the blend radius
SLOWINGS = 3  # of a transition in which the tool is too fast
SLOWER = 1.05  # times the excess
DELAYS = (0.0, 0.2, 0.4, 0.6)  # of the rest of the first motion, where efforts require it


def blend(
    first: Trajectory,
    second: Trajectory,
    radius: float,
    model: RobotModel,
    world: CollisionWorld | None,
) -> BlendedTrajectory | None:
    """Change from one motion to another in the shortest time within the limits of all joints.

    The transition begins at once and ends in a state of the second motion. It keeps position,
    velocity, acceleration, jerk and effort limits, the clearance of planned motions, and the tool
    within the blend radius of the corner.

    Args:
        first: The rest of the present motion; its end is the corner.
        second: Starts at rest in the corner.
        radius: Blend radius [m].
        model: The arm with its payload.
        world: The collision world; None does not check.

    Returns:
        The transition and the rest of the second motion; None where none of a few arrivals is
        feasible, or earlier than after coming to rest.
    """
    corner = model.pose(first.end).copy()
    last = _last_arrival(second, radius, model, corner)
    found = []
    for delay, part in product(DELAYS, ARRIVALS):
        start, arrival = delay * first.duration, last * part
        transition = _transition(first, start, second, arrival, model.limits)
        for _ in range(SLOWINGS if model.limits.limits_tool else 0):
            if transition is None or (use := tool_use(transition, model.limits)) <= 1.0:
                break
            slower = SLOWER * use * transition.duration
            transition = _transition(first, start, second, arrival, model.limits, slower)
        if transition is not None:
            found.append((start + transition.duration - arrival, start, transition, arrival))
    for duration, start, transition, arrival in sorted(found, key=itemgetter(0)):
        if duration >= first.duration:
            break
        end = start + transition.duration
        parts = [first, transition, TailTrajectory(second, arrival)]
        blended = BlendedTrajectory(parts, [0.0, start, end])
        samples = blended.sample(sample_times(end, CONTROL_STEP))
        if (
            model.limits.use(*samples).inside
            and tool_distance(model, _positions(transition), corner).max() <= radius
            and tool_use(blended, model.limits) <= 1.0
            and effort_use(transition, model) <= EFFORT_FRACTION
            and (world is None or trajectory_is_free(world, transition, second.end))
        ):
            return blended
    return None


def tool_distance(model: RobotModel, configurations: np.ndarray, T_wt: pin.SE3) -> np.ndarray:
    """Return the distances of the tool from a pose [m].

    A rotation counts as the travel of a point `BLEND_LEVER` from its axis.

    Args:
        model: The arm.
        configurations: Configurations [rad].  # (n, nq)
        T_wt: The pose in the world.
    """  # (n,)
    errors = [T_wt.actInv(model.pose(q)) for q in configurations]
    position = np.array([np.linalg.norm(error.translation) for error in errors])
    angle = np.array([np.linalg.norm(pin.log3(error.rotation)) for error in errors])
    return np.maximum(position, BLEND_LEVER * angle)


def _last_arrival(second: Trajectory, radius: float, model: RobotModel, corner: pin.SE3) -> float:
    """Return the time until which a motion keeps the tool within a radius of the corner.

    The radius is at most `MAX_BLEND` of the distance that the motion moves the tool.
    """
    distances = tool_distance(model, _positions(second), corner)
    inside = distances <= min(radius, MAX_BLEND * distances[-1])
    return (int(inside.argmin()) - 1) / BLEND_SAMPLES * second.duration


def _transition(
    first: Trajectory,
    start: float,
    second: Trajectory,
    arrival: float,
    limits: MotionLimits,
    shortest: float = 0.0,
) -> JointTrajectory | None:
    """Return the fastest transition between two times of two motions; None where there is none."""
    state = [rows[0] for rows in first.sample(np.array([start]))]
    target, v, a = (rows[0] for rows in second.sample(np.array([arrival])))
    bounds = limits.velocity, limits.acceleration, limits.jerk
    try:
        return JointTrajectory(joint_profiles((*state,), target, *bounds, (v, a), shortest))
    except MotionError:
        return None


def _positions(trajectory: Trajectory) -> np.ndarray:
    return trajectory.sample(np.linspace(0.0, trajectory.duration, BLEND_SAMPLES + 1))[0]
