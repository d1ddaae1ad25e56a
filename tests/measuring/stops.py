"""Stops at random times of random motions, compared with the shortest time to stop."""

import time
from typing import NamedTuple

import numpy as np

from bt_manip.arm import Arm
from bt_manip.robots import RobotDescription
from bt_manip.trajectories import (
    PathLimits,
    PathTrajectory,
    SequenceTrajectory,
    TailTrajectory,
    time_scaling_state,
)
from bt_manip.trajectories.stop_search import shortest_stop_time
from tests.measuring.motions import KINDS, STEP, advance, begin
from tests.measuring.scenes import Planned, random_scene

STOPS_PER_SCENE = 10


class Stop(NamedTuple):
    """One stop."""

    kind: str  # of the motion that was stopped
    duration: float  # [s] until rest
    shortest: float  # [s] longest of the times that each coordinate alone needs to stop
    remaining: float  # [s] that the motion would have lasted
    off_path: float  # [rad] largest distance of a joint from the path
    limit_use: float  # largest used fraction of a velocity, acceleration, jerk or effort limit
    computing: float  # [ms] of processor time for the stop

    @property
    def ratio(self) -> float:
        """Duration over the shortest time."""
        return self.duration / self.shortest


def measure_stops(count: int, description: RobotDescription | None = None) -> list[Stop]:
    """Stop motions of all kinds in turn, in random scenes, with any robot (default: the Panda)."""
    stops: list[Stop] = []
    rng = np.random.default_rng(3)
    for number in range(count):
        if number % STOPS_PER_SCENE == 0:
            planned, start, goal = random_scene(number // STOPS_PER_SCENE, description)
            planned.arm.guard = None  # the reference moves alone
        kind = KINDS[number % len(KINDS)]
        begin(planned, kind, start, goal, number)
        stops.append(_measure(planned, kind, float(rng.uniform(0.03, 0.97))))
    return stops


def _measure(planned: Planned, kind: str, share: float) -> Stop:
    """Stop a motion after a share of its duration."""
    arm = planned.arm
    undisturbed = Arm(planned.robot, model=arm.model, ik=arm.ik)
    undisturbed.set_state(arm.get_state())
    path = [undisturbed.q_ref]
    while undisturbed.moving:
        undisturbed.advance(STEP)
        path.append(undisturbed.q_ref)
    advance(planned, share)
    shortest, remaining = _shortest(arm), arm.remaining
    samples = [(arm.q_ref, arm.v.copy(), arm.a.copy())]
    began = time.thread_time()
    arm.stop()
    computing, duration = 1e3 * (time.thread_time() - began), arm.remaining
    while arm.moving:
        arm.advance(STEP)
        samples.append((arm.q_ref, arm.v.copy(), arm.a.copy()))
    off_path = max(distance(np.array(path), q) for q, _, _ in samples)
    use = _limit_use(arm, samples)
    return Stop(kind, duration, shortest, remaining, off_path, use, computing)


def _shortest(arm: Arm) -> float:
    """Return the longest of the times that each coordinate of the path alone needs to stop [s]."""
    trajectory = arm.trajectory
    t = trajectory.duration - arm.remaining
    if isinstance(trajectory, SequenceTrajectory):
        trajectory, t = trajectory.active(t)
    while isinstance(trajectory, TailTrajectory):
        trajectory, t = trajectory.trajectory, t + trajectory.start
    nominal, (s, s_dot, s_ddot) = time_scaling_state(trajectory, t)
    others, sample = np.empty((3, 0)), nominal.sample
    if isinstance(nominal, PathTrajectory):
        others, sample = nominal.path.limits, nominal.sample_coordinates
    _, v, a = (rows[0] for rows in sample(np.array([s])))
    return shortest_stop_time(
        v * s_dot, a * s_dot**2 + v * s_ddot, PathLimits(arm.model.limits, others)
    )


def distance(path: np.ndarray, q: np.ndarray) -> float:
    """Return the distance of a configuration from a polyline, as the largest of a joint [rad]."""
    i = int(np.abs(path - q).max(axis=1).argmin())
    nearest = np.abs(path[i] - q).max()
    for a, b in zip(path[max(0, i - 1) : i + 1], path[max(0, i - 1) + 1 : i + 2], strict=False):
        segment = b - a
        part = np.clip((q - a) @ segment / max(segment @ segment, 1e-30), 0.0, 1.0)
        nearest = min(nearest, np.abs(a + part * segment - q).max())
    return float(nearest)


def _limit_use(arm: Arm, samples: list[tuple[np.ndarray, ...]]) -> float:
    limits, model = arm.model.limits, arm.model
    _, v, a = (np.array(column) for column in zip(*samples, strict=True))
    efforts = np.array([model.effort(*row) for row in samples])
    fractions = (
        v / limits.velocity,
        a / limits.acceleration,
        np.diff(a, axis=0) / STEP / limits.jerk,
        efforts / limits.effort,
    )
    return max(float(np.abs(fraction).max(initial=0.0)) for fraction in fractions)
