"""Motions through random scenes, executed in simulation."""

import time
from typing import NamedTuple

import numpy as np

from bt_manip.collision import FreeSpace
from bt_manip.exceptions import MotionError
from bt_manip.planning import PlanningProblem, RRTConnect
from bt_manip.robots import RobotDescription
from tests.measuring.scenes import Planned, put, random_scene
from tests.measuring.time_optimal_duration import missing, time_optimal_duration

LONG = 20_000  # samples of the search that tells whether a path exists
GOAL_TOLERANCE = 0.01  # [rad]


class Execution(NamedTuple):
    """The result of planning and executing a motion through one scene."""

    refused: str  # why no motion was planned; empty where one was
    planning: float = np.nan  # [ms] of processor time until there was a checked trajectory
    duration: float = np.nan  # [s] of the motion
    ratio: float = np.nan  # of that to the time-optimal one on its path; nan without toppra
    error: float = np.nan  # [rad] largest deviation of a joint from the reference
    touched: bool = False  # whether the arm came into contact with anything
    saturated: bool = False  # whether a motor reached its limit
    reached: bool = False  # whether the arm reached the goal
    solvable: bool = True  # whether a path exists: after a refusal, by a search without clearance


def execute_scenes(count: int, description: RobotDescription | None = None) -> list[Execution]:
    """Plan and execute motions in random scenes until a number of them is solvable.

    The robot is the Panda by default. Results of scenes without a path are among the returned ones.
    """
    found: list[Execution] = []
    while sum(execution.solvable for execution in found) < count:
        found.append(_execute(*random_scene(len(found), description), len(found)))
    return found


def _execute(planned: Planned, start: np.ndarray, goal: np.ndarray, seed: int) -> Execution:
    arm, cell = planned.arm, planned.cell
    put(planned, start)
    begun = time.thread_time()
    try:
        arm.move_to_configuration(goal, rng=np.random.default_rng(seed))
    except MotionError as error:
        return Execution(str(error), solvable=_is_solvable(planned, start, goal, seed))
    planning, duration = 1e3 * (time.thread_time() - begun), arm.remaining
    ratio = np.nan if missing() else duration / time_optimal_duration(arm.trajectory, arm.model)
    worst, touched = 0.0, False
    while arm.moving:
        cell.step()
        worst = max(worst, float(np.abs(planned.robot.q - arm.q).max()))
        touched |= bool(cell.data.ncon) and bool(cell.contacts.partners(planned.name))
    return Execution(
        refused="",
        planning=planning,
        duration=duration,
        ratio=ratio,
        error=worst,
        touched=touched,
        saturated=planned.control.saturated_steps > 0,
        reached=np.array_equal(arm.q, goal) and worst < GOAL_TOLERANCE,
    )


def _is_solvable(planned: Planned, start: np.ndarray, goal: np.ndarray, seed: int) -> bool:
    """Tell whether a long search finds a path."""
    world, limits = planned.arm.world, planned.arm.model.limits
    assert world is not None
    is_free = FreeSpace(world, start, [goal], clearance=0.0).is_free
    rng = np.random.default_rng(seed)
    problem = PlanningProblem(start, goal[np.newaxis], is_free, limits, rng)
    return len(RRTConnect(samples=LONG).plan(problem).path) > 0
