"""Placement of a robot at a table, and its home configuration."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.collision import hull_points
from bt_manip.robots import Robot, RobotError

from .reach import GRASP_HEIGHT, DownwardReach, RadialReach, foot_bodies

# Scene with a table and a basket, in the frame where it places the robot [m].
_PICK_X, _PICK_Y = (0.3, 0.4, 0.5), (-0.3, -0.15, 0.0, 0.15, 0.3)
_PICK_HEIGHTS = (GRASP_HEIGHT, 0.15, 0.4)  # to grip a cube, to lift it clear, to carry it
_BASKET_X, _BASKET_HEIGHTS = 0.78, (0.25, 0.22, 0.19)  # heights of the tool over the table
_TABLE_X = (-0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
_TABLE_Y = (-0.35, -0.25, -0.15, -0.05, 0.05, 0.15, 0.25, 0.35)

BASE_X, _BASE_Z = np.arange(0.0, 0.41, 0.05), np.arange(0.0, 0.21, 0.05)  # [m] offsets
_LEAST_TABLE = 0.1  # least share of the table within reach
_MOVED = 1.0  # [1/m] cost of an offset of the base, in shares of reached positions
_HOME_HEIGHT = 0.3  # [m] height of the tool over the table at home; less for small arms
FOOT = (0.05, 0.15)  # [m] bounds of the half width of a pedestal
_DIGITS = 3  # decimals of the base position [m]


class Placement(NamedTuple):
    """Pose and support of a robot's base."""

    T_rb: pin.SE3
    """Pose of the base in the frame where the scene places the robot."""
    pedestal: tuple[float, float, float] | None
    """Size of the block under the base [m]; None: no block."""


def place_base(robot: Robot, reach: RadialReach) -> Placement:
    """Return the base pose that reaches the most of a table with the smallest offset."""
    lowest, footprint = measure_foot(robot)
    yaw = -round(2.0 * reach.front / np.pi) * np.pi / 2.0
    c, s = np.cos(yaw), np.sin(yaw)
    axis = np.array([[c, -s], [s, c]]) @ reach.axis
    best: tuple[float, Placement] | None = None
    for lift in _BASE_Z:
        for x in BASE_X:
            z = round(float(lift) - lowest, _DIGITS)
            score = _score(reach, np.array([x, 0.0]) + axis, z) - _MOVED * float(x + lift)
            if best is None or score > best[0] + 1e-9:
                quat = (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2))
                T_rb = spatial.pose((round(float(x), _DIGITS), 0.0, z), quat)
                size = (2.0 * footprint, 2.0 * footprint, round(float(lift), _DIGITS))
                best = score, Placement(T_rb, size if lift > 0.0 else None)
    assert best is not None
    return best[1]


def find_home(downward: DownwardReach, reach: RadialReach, base: pin.SE3) -> np.ndarray:
    """Return a configuration with the tool pointing down over the middle of the reach.

    Solver and reach are those of the robot at its original base, whose pose relative to the table
    is ``base``.

    Raises:
        RobotError: If no configuration free of self-collision has the tool pointing down.
    """
    direction = np.array([np.cos(reach.front), np.sin(reach.front)])
    height = min(_HOME_HEIGHT, 0.4 * reach.radii[-1]) - base.translation[2]
    possible = reach.reached(-base.translation[2])
    rows = np.argsort(np.abs(reach.heights - height), kind="stable")
    for row in rows:
        reached = reach.radii[possible[row]]
        if not reached.size:
            continue
        middle = 0.5 * (reached[0] + reached[-1])
        for radius in reached[np.argsort(np.abs(reached - middle), kind="stable")]:
            position = [*(reach.axis + radius * direction), reach.heights[row]]
            q = downward.configuration(np.array(position), -base.translation[2])
            if q is not None:
                return q
    blocking = downward.blocking()
    if blocking:
        pairs = ", ".join(f"'{one}' and '{other}'" for one, other in blocking)
        raise RobotError(
            "no configuration free of self-collision has the tool pointing down; these bodies "
            f"collide: {pairs}; check their geoms in the model"
        )
    raise RobotError(
        "no configuration has the tool pointing down: check the tool's frame and its z axis, which "
        "is the direction of approach (--tool-frame)"
    )


def _score(reach: RadialReach, axis: np.ndarray, z: float) -> float:
    """Return a score of a base pose by the shares of positions of the task that it reaches."""

    def share(x: Sequence[float], y: Sequence[float], height: float) -> float:
        points = np.array(np.meshgrid(x, y)).reshape(2, -1)
        radius = np.hypot(points[0] - axis[0], points[1] - axis[1])
        return float(reach.covers(radius, np.full(radius.shape, height - z), -z).mean())

    pick = [share(_PICK_X, _PICK_Y, height) for height in _PICK_HEIGHTS]
    table = min(share(_TABLE_X, _TABLE_Y, height) for height in _PICK_HEIGHTS[:2])
    basket = [share([_BASKET_X], [0.0], height) for height in _BASKET_HEIGHTS]
    score = min(pick[:2]) + 0.3 * pick[2] + table
    return score + min(1.0, table / _LEAST_TABLE) * (2.0 * max(basket) + 0.3 * basket[0])


def measure_foot(robot: Robot) -> tuple[float, float]:
    """Return the height of the lowest point of the foot, and its half width [m]."""
    model, data = robot.mj_model, robot.mj_data
    points = []
    fixed = np.zeros((1, 2))
    for geom in np.flatnonzero(foot_bodies(robot)[model.geom_bodyid]):
        R = data.geom_xmat[geom].reshape(3, 3)
        points.append(hull_points(model, int(geom)) @ R.T + data.geom_xpos[geom])
        if model.body_weldid[model.geom_bodyid[geom]] == 0:
            fixed = np.concatenate([fixed, points[-1][:, :2]])
    if not points:
        return 0.0, FOOT[0]
    half = float(np.clip(np.abs(fixed).max(), *FOOT))
    return round(float(np.concatenate(points)[:, 2].min()), _DIGITS), round(half, 2)
