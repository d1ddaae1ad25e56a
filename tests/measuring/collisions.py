"""Collisions of a moving arm with a wall that no planner knows of."""

from typing import NamedTuple

import numpy as np

from bt_manip import build_station, spatial
from bt_manip.arm import Arm
from bt_manip.registry import Parts
from bt_manip.runner import Station
from bt_manip.scenes import Scene, SceneRobot
from tests.measuring.scenes import Fixed

STRETCHED = (0.0, 0.5, 0.0, -1.6, 0.0, 2.1, 0.785)
"""A configuration of the Panda with the tool 0.5 m beside the base [rad]."""

RELIEF_TIME = 0.5  # [s] after the first contact, from which the arm must not press
_SWEEP = 1.6  # [rad] of the first joint to either side
_AHEAD = 0.5  # [rad] of the first joint before the wall, when the wall appears


class Collision(NamedTuple):
    """A collision with a wall."""

    speed: float  # [rad/s] of the first joint at the first contact
    forces: np.ndarray  # [N] normal force on the wall in each step since then
    start: np.ndarray  # [rad] where the motion began  (nq,)

    @property
    def lasting(self) -> float:
        """Largest normal force from `RELIEF_TIME` on [N]."""
        return float(self.forces[round(RELIEF_TIME * 1e3) :].max())


def one_arm(controller: str, parts: Parts | None = None) -> Station:
    """Build a Panda that stands alone, with a registered controller."""
    scene = Scene((SceneRobot(spatial.pose((0.0, 0.0, 1.0))),))
    return build_station(parts, controller=controller, scene=scene)


def collide(
    station: Station, duration: float, configuration: tuple[float, ...] | None = None
) -> Collision:
    """Sweep the first joint at full speed into a wall that appears on its path, and stay there.

    Args:
        station: A station with one robot, from `one_arm`.
        duration: Simulated time since the first contact [s].
        configuration: The other joints [rad]; by default those of home.
    """
    cell, arm = station.cell, station.arm
    middle = np.array(arm.model.home if configuration is None else configuration)
    start, goal = middle.copy(), middle.copy()
    start[0], goal[0] = -_SWEEP, _SWEEP
    drive(station, start)
    arm.move_to_configuration(goal)
    station.step_until(lambda: bool(arm.q[0] > -_AHEAD))
    tool = arm.model.pose(middle).translation
    at = tool + np.array([0.08, 0.1, 0.0])
    cell.add(Fixed("box", (0.15, 0.05, 0.25), "wall"), spatial.pose(at), name="wall", free=False)
    speed = 0.0
    while not (force := wall_force(station)):
        speed = float(arm.robot.v[0])
        cell.step()
    forces = [force]
    for _ in range(round(duration / cell.dt)):
        cell.step()
        forces.append(wall_force(station))
    return Collision(speed, np.array(forces), start)


def drive(station: Station, q: np.ndarray) -> float:
    """Move to a configuration [rad]; return the largest normal force on the wall [N]."""
    arm: Arm = station.arm
    arm.move_to_configuration(q)
    largest = 0.0
    while arm.moving:
        station.cell.step()
        largest = max(largest, wall_force(station))
    station.cell.step(300)
    return largest


def wall_force(station: Station) -> float:
    """Sum the normal forces on the wall [N]; 0 where there is none."""
    cell = station.cell
    return (
        sum(point.force for point in cell.contacts.points("wall"))
        if "wall" in cell.entities
        else 0.0
    )
