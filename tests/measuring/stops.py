"""Halts at random moments, next to a time in which no clock on the path could make them."""

import time
from typing import NamedTuple

import numpy as np

from bt_manip.arm import Arm
from bt_manip.robots import RobotDescription
from bt_manip.trajectories import PathTrajectory, SequenceTrajectory, TimeScaledTrajectory
from bt_manip.trajectories.kinematic_limits import KinematicLimits
from bt_manip.trajectories.stop_search import shortest_rest
from bt_manip.trajectories.time_scaling_limits import Curve, State
from bt_manip.trajectories.trajectory import TailTrajectory
from tests.measuring.motions import KINDS, STEP, advance, begin
from tests.measuring.scenes import Planned, random_scene

EACH = 10  # halts in one scene


class Halt(NamedTuple):
    """One halt.

    Attributes:
        kind: Of the motion that was halted.
        duration: Until rest [s].
        shortest: The longest time that any coordinate needs to stop, each by itself [s].
        off: Farthest from the path [rad].
        used: Largest share of a limit of velocity, acceleration, jerk or effort.
        computing: Processor time of the stop [ms].
    """

    kind: str
    duration: float
    shortest: float
    off: float
    used: float
    computing: float

    @property
    def ratio(self) -> float:
        """The duration over the shortest."""
        return self.duration / self.shortest


def halts(count: int, description: RobotDescription | None = None) -> list[Halt]:
    """Halt motions of every kind in turn, ten in a scene, with any robot."""
    found: list[Halt] = []
    rng = np.random.default_rng(3)
    for number in range(count):
        if number % EACH == 0:
            planned, start, goal = random_scene(number // EACH, description)
            planned.arm.guard = None  # the reference moves alone
        kind = KINDS[number % len(KINDS)]
        begin(planned, kind, start, goal, number)
        found.append(halt(planned, kind, float(rng.uniform(0.03, 0.97))))
    return found


def halt(planned: Planned, kind: str, share: float) -> Halt:
    """Halt a motion once a share of it is done."""
    arm = planned.arm
    undisturbed = Arm(planned.robot, model=arm.model, ik=arm.ik)
    undisturbed.set_state(arm.get_state())
    way = [undisturbed.q_ref]
    while undisturbed.moving:
        undisturbed.advance(STEP)
        way.append(undisturbed.q_ref)
    advance(planned, share)
    curve, state = clock_of(arm)
    rows = [(arm.q_ref, arm.v.copy(), arm.a.copy())]
    begun = time.thread_time()
    arm.stop()
    computing, duration = 1e3 * (time.thread_time() - begun), arm.remaining
    while arm.moving:
        arm.advance(STEP)
        rows.append((arm.q_ref, arm.v.copy(), arm.a.copy()))
    s_now, s_dot, s_ddot = state
    _, d1, d2 = (x[0] for x in curve.evaluate(np.array([s_now])))
    shortest = shortest_rest(d1 * s_dot, d2 * s_dot**2 + d1 * s_ddot, curve.bounds)
    off = _off(rows, np.array(way))
    return Halt(kind, duration, shortest, off, _used(arm, rows), computing)


def clock_of(arm: Arm) -> tuple[Curve, State]:
    """Give the path that an arm is on, and the state of the clock that goes along it."""
    trajectory, t = arm.trajectory, arm.trajectory.duration - arm.remaining
    if isinstance(trajectory, SequenceTrajectory):
        trajectory, t = trajectory.active(t)
    while isinstance(trajectory, TailTrajectory):
        trajectory, t = trajectory.trajectory, t + trajectory.start
    pace, change = 1.0, 0.0
    if isinstance(trajectory, TimeScaledTrajectory):
        t, pace, change = trajectory.time_scaling.at(t)
        trajectory = trajectory.nominal
    if isinstance(trajectory, PathTrajectory):
        s, ds, dds = trajectory.profile.at(t)
        state = (s, ds * pace, dds * pace * pace + ds * change)
        return Curve(trajectory.path.evaluate, trajectory.limits, 1.0), state
    bounds = KinematicLimits.of_joints(arm.model.limits)
    return Curve(trajectory.sample, bounds, trajectory.duration), (t, pace, change)


def _off(rows: list[tuple[np.ndarray, ...]], way: np.ndarray) -> float:
    """Give how far configurations are from a way, straight between its samples [rad]."""
    worst = 0.0
    for q, *_ in rows:
        i = int(np.abs(way - q).max(axis=1).argmin())
        nearest = np.abs(way[i] - q).max()
        for a, b in zip(way[max(0, i - 1) : i + 1], way[max(0, i - 1) + 1 : i + 2], strict=False):
            along = b - a
            part = np.clip((q - a) @ along / max(along @ along, 1e-30), 0.0, 1.0)
            nearest = min(nearest, np.abs(a + part * along - q).max())
        worst = max(worst, float(nearest))
    return worst


def _used(arm: Arm, rows: list[tuple[np.ndarray, ...]]) -> float:
    limits, model = arm.model.limits, arm.model
    _, v, a = (np.array(column) for column in zip(*rows, strict=True))
    efforts = np.array([model.effort(*row) for row in rows])
    shares = (
        v / limits.velocity,
        a / limits.acceleration,
        np.diff(a, axis=0) / STEP / limits.jerk,
        efforts / limits.effort,
    )
    return max(float(np.abs(share).max(initial=0.0)) for share in shares)
