"""Random scenes, driven through in physics."""

import time
from typing import NamedTuple

import numpy as np

from bt_manip.collision import FreeSpace
from bt_manip.exceptions import MotionError
from bt_manip.planning import PlanningProblem, RRTConnect
from bt_manip.robots import RobotDescription
from tests.measuring.fastest_drive import fastest_time, missing
from tests.measuring.scenes import Planned, put, random_scene

LONG = 20_000  # samples of the search that tells whether there is a way at all
ARRIVED = 0.01  # [rad] from the goal, at the most


class Drive(NamedTuple):
    """What came of one scene.

    Attributes:
        refused: Why nothing was driven; empty where it was.
        planning: Processor time until there was a checked trajectory [ms].
        duration: Of the motion [s].
        ratio: That over the time-optimal one on the same path; nan where toppra is missing.
        error: Largest deviation of a joint from the reference [rad].
        touched: Whether the arm came into contact with anything.
        saturated: Whether a motor was at its limit.
        reached: Whether the arm was at the goal in the end.
        solvable: Whether there is a way; of scenes that are refused a long search tells, which
            keeps no clearance.
    """

    refused: str
    planning: float = np.nan
    duration: float = np.nan
    ratio: float = np.nan
    error: float = np.nan
    touched: bool = False
    saturated: bool = False
    reached: bool = False
    solvable: bool = True


def drives(count: int, description: RobotDescription | None = None) -> list[Drive]:
    """Drive from start to goal in scenes drawn from the first seeds, with any robot.

    In some scenes nothing leads from start to goal, mostly for an arm of six joints. These are
    given too, but there are as many others as are asked for.
    """
    found: list[Drive] = []
    while sum(drive.solvable for drive in found) < count:
        found.append(_drive(*random_scene(len(found), description), len(found)))
    return found


def _drive(planned: Planned, start: np.ndarray, goal: np.ndarray, seed: int) -> Drive:
    arm, cell = planned.arm, planned.cell
    put(planned, start)
    begun = time.thread_time()
    try:
        arm.move_to_configuration(goal, rng=np.random.default_rng(seed))
    except MotionError as error:
        return Drive(str(error), solvable=_solvable(planned, start, goal, seed))
    planning, duration = 1e3 * (time.thread_time() - begun), arm.remaining
    ratio = np.nan if missing() else duration / fastest_time(arm.trajectory, arm.model)
    worst, touched = 0.0, False
    while arm.moving:
        cell.step()
        worst = max(worst, float(np.abs(planned.robot.q - arm.q).max()))
        touched |= bool(cell.data.ncon) and bool(cell.contacts.partners(planned.name))
    return Drive(
        refused="",
        planning=planning,
        duration=duration,
        ratio=ratio,
        error=worst,
        touched=touched,
        saturated=planned.control.saturated_steps > 0,
        reached=np.array_equal(arm.q, goal) and worst < ARRIVED,
    )


def _solvable(planned: Planned, start: np.ndarray, goal: np.ndarray, seed: int) -> bool:
    """Tell whether a long search finds a way."""
    world, limits = planned.arm.world, planned.arm.model.limits
    assert world is not None
    free = FreeSpace(world, start, [goal], clearance=0.0).is_free
    rng = np.random.default_rng(seed)
    problem = PlanningProblem(start, goal[np.newaxis], free, limits, rng)
    return len(RRTConnect(samples=LONG).plan(problem).path) > 0
