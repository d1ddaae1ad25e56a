"""The reference on its way along a trajectory: pace, pause, stop."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotModel
from bt_manip.trajectories import (
    CONTROL_STEP,
    Samples,
    TimeScaledTrajectory,
    Trajectory,
    at_speed_scale,
    change_speed_scale,
    sample_times,
    sampled_limit_use,
    trajectory_from_state,
)

from .motion_planning import Present, plan_stop_from

_LEAST = 1e-3  # of the planned speed, below which it is next to rest


class Reference:
    """Goes through trajectories, step by step.

    Attributes:
        q: Position [rad], read-only and live.  # (nq,)
        v: Velocity [rad/s], read-only and live.  # (nq,)
        a: Acceleration [rad/s2], read-only and live.  # (nq,)
        trajectory: What is followed; None at rest.
        paused: A trajectory in whose middle it rests, and where in it [s]; None where it does not.
        pace: Fraction of their planned speed that trajectories are driven at.
        lagging: Whether the limits did not allow to change to that pace at all yet, or as fast as
            they may later.
        step: Control steps since the trajectory was last tabulated.
    """

    def __init__(self, q: np.ndarray) -> None:
        """Stand at a configuration [rad]."""
        self._now = np.zeros(3 * len(q))  # flat, because that is copied faster
        live = self._now.reshape(3, -1)
        live.setflags(write=False)
        self.q, self.v, self.a = live
        self.reset(q)

    def reset(self, q: np.ndarray) -> None:
        """Forget all motion and stand at a configuration [rad]."""
        self._now[:] = 0.0
        self._now[: len(q)] = q
        self.trajectory: Trajectory | None = None
        self.paused: tuple[Trajectory, float] | None = None
        self.pace, self._stopping, self.lagging = 1.0, False, False
        self._start = 0.0  # [s] into the trajectory, where the table begins
        self._dt = 1e-3
        self.step = self._last = 0

    def hold_at(self, q: np.ndarray) -> None:
        """Stand at another configuration [rad]; it must be at rest."""
        self._now[: len(q)] = q

    @property
    def present(self) -> Present:
        """What it does now."""
        return Present(self.q, self.v, self.a, self.trajectory, self.time)

    def presents(self) -> Iterator[Present]:
        """Give what it does now, for those who plan what comes next.

        At a pace of its own it first gives what it would do at full pace: what is planned from
        there is driven at that pace too, and goes the same way at any.
        """
        trajectory, time = self.trajectory, self.time
        if isinstance(trajectory, TimeScaledTrajectory) and not self._stopping:
            now, pace, change = trajectory.time_scaling.at(time)
            whole = trajectory.nominal
            _, v, a = (rows[0] for rows in whole.sample(np.array([min(now, whole.duration)])))
            if pace > _LEAST and now < whole.duration:
                yield Present(self.q, v, a, whole, now, pace, change)
        yield self.present

    @property
    def time(self) -> float:
        """Time since the start of the trajectory [s]."""
        return self._start + self.step * self._dt

    @property
    def remaining(self) -> float:
        """Time until it comes to rest [s]."""
        return 0.0 if self.trajectory is None else max(0.0, self.trajectory.duration - self.time)

    @property
    def stopping(self) -> bool:
        """Whether it comes to rest without going on afterwards."""
        return self._stopping and self.trajectory is not None

    def ahead(self, times: np.ndarray) -> np.ndarray:
        """Give where it will be after some times from now on [rad]."""  # (n, nq)
        trajectory = self.trajectory
        if trajectory is None:
            return np.tile(self.q, (len(times), 1))
        return trajectory.sample(np.minimum(self.time + times, trajectory.duration))[0]

    def begin(self, trajectory: Trajectory | None, since: Present, model: RobotModel) -> bool:
        """Take a planned motion, at the present pace; None is no motion.

        Args:
            trajectory: The motion.
            since: What it was planned from.
            model: The arm with its payload.

        Returns:
            False where it cannot go on at the pace of what it was planned from; then nothing
            changes.

        Raises:
            MotionError: When it exceeds a limit; then nothing changes.
        """
        if trajectory is None:
            self.paused = None
            return True
        rest = not (self.v.any() or self.a.any())
        pace, change = (self.pace, 0.0) if rest else (since.pace, since.change)
        stops = not rest and isinstance(trajectory, TimeScaledTrajectory)  # and that is all it does
        if rest and pace == 0.0:
            self._proven(trajectory, model)
            self.trajectory, self.paused = None, (trajectory, 0.0)
            self._stopping = self.lagging = False
            return True
        driven: Trajectory | None = trajectory
        wanted = pace if stops else self.pace
        lagging = False
        if (pace, change, wanted) != (1.0, 0.0, 1.0):
            found = change_speed_scale(trajectory, (0.0, pace, change), wanted, model)
            driven, lagging = None, True
            if found is not None:
                driven, lagging = found.trajectory, not found.brisk
            elif change == 0.0:
                driven = trajectory if pace == 1.0 else at_speed_scale(trajectory, 0.0, pace)
        if driven is None:
            return False
        self.follow(driven, model)
        self.paused, self._stopping, self.lagging = None, stops, lagging
        return True

    def stop(self, model: RobotModel) -> None:
        """Come to rest as soon as the limits allow, and give the motion up."""
        self.paused, self._stopping, self.lagging = None, True, False
        if not (self.v.any() or self.a.any()):  # not begun yet
            self.trajectory, self._stopping = None, False
            return
        self.follow(plan_stop_from(self.present, model), model)

    def set_speed_scale(self, pace: float, model: RobotModel) -> None:
        """Go on at another fraction of the planned speed; 0 pauses.

        Where the limits do not allow that now, it goes on as it was, and lags.
        """
        lagging = False
        if self.paused is not None:
            if pace > 0.0:
                whole, since = self.paused
                # At its start a trajectory itself sets out from rest.
                lagging = self._go_on(whole, (since, 0.0 if since else pace, 0.0), pace, model)
        elif self.trajectory is not None and not self._stopping:
            trajectory, t = self.trajectory, self.time
            if isinstance(trajectory, TimeScaledTrajectory):
                clock = trajectory.time_scaling.at(t)
                lagging = self._go_on(trajectory.nominal, clock, pace, model)
            else:
                lagging = self._go_on(trajectory, (t, 1.0, 0.0), pace, model)
        self.pace, self.lagging = pace, lagging

    def _go_on(
        self, whole: Trajectory, clock: tuple[float, float, float], pace: float, model: RobotModel
    ) -> bool:
        """Change the pace of a motion as far as possible; tell whether it lags."""
        found = change_speed_scale(whole, clock, pace, model)
        if found is None:
            return True
        self.follow(found.trajectory, model)
        self.paused = None
        return not found.brisk

    def follow(self, trajectory: Trajectory | None, model: RobotModel) -> None:
        """Follow a trajectory, once it is proven to be inside the limits."""
        if trajectory is None:
            return
        rows = self._proven(trajectory, model)
        self.trajectory, self._start = trajectory, 0.0
        if self._dt == CONTROL_STEP:
            self._keep(rows)
        else:
            self._tabulate()

    def _proven(self, trajectory: Trajectory, model: RobotModel) -> Samples:
        """Tabulate a trajectory that is inside the limits.

        Raises:
            MotionError: When it is not.
        """
        rows = trajectory.sample(sample_times(trajectory.duration, CONTROL_STEP))
        use = sampled_limit_use(rows, model.limits)
        if not use._replace(position=0.0).inside or not self._allows(use.position, model):
            raise MotionError(f"the planned motion exceeds a limit: {use}", reason="limits")
        return rows

    def _allows(self, used: float, model: RobotModel) -> bool:
        """Tell whether a use of the position limits is none, or no more than here already."""
        limits = model.limits
        middle, half = 0.5 * (limits.upper + limits.lower), 0.5 * (limits.upper - limits.lower)
        bounded = np.isfinite(half)
        here = float((np.abs(self.q - middle)[bounded] / half[bounded]).max(initial=0.0))
        return used <= max(1.0, here) + 1e-9

    def advance(self, dt: float) -> None:
        """Move on by a control step [s]."""
        if self.trajectory is None:
            return
        if dt != self._dt:
            self._start, self._dt = self.time, dt
            self._tabulate()
        self.step = step = self.step + 1
        self._now[:] = self._rows[step]
        if step == self._last:
            self._end()

    def _end(self) -> None:
        """Be at the end of a trajectory, or at rest in the middle of one."""
        ended, self.trajectory = self.trajectory, None
        if isinstance(ended, TimeScaledTrajectory) and not (self._stopping or ended.complete):
            self.paused = ended.nominal, ended.time_scaling.end
        self._stopping = self.lagging = False

    def _tabulate(self) -> None:
        """Sample the rest of the trajectory at once: a step costs little then."""
        assert self.trajectory is not None
        times = self._start + sample_times(self.trajectory.duration - self._start, self._dt)
        self._keep(self.trajectory.sample(times))

    def _keep(self, rows: Samples) -> None:
        self._rows = np.concatenate(rows, axis=1)
        self.step, self._last = 0, len(self._rows) - 1

    def get_state(self) -> dict[str, Any]:
        """Give everything as plain data."""
        trajectory, paused = self.trajectory, self.paused
        return {
            "q": self.q.tolist(),
            "v": self.v.tolist(),
            "a": self.a.tolist(),
            "trajectory": None if trajectory is None else trajectory.get_state(),
            "start": self._start,
            "dt": self._dt,
            "step": self.step,
            "pace": self.pace,
            "stopping": self._stopping,
            "lagging": self.lagging,
            "paused": None if paused is None else [paused[0].get_state(), paused[1]],
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Take everything back; it goes on bit for bit."""
        self._now[:] = (*state["q"], *state["v"], *state["a"])
        trajectory, paused = state["trajectory"], state["paused"]
        self.trajectory = None if trajectory is None else trajectory_from_state(trajectory)
        self._start, self._dt = state["start"], state["dt"]
        if self.trajectory is not None:
            self._tabulate()
        self.step = state["step"]
        self.pace, self._stopping = state["pace"], state["stopping"]
        self.lagging = state["lagging"]
        self.paused = None if paused is None else (trajectory_from_state(paused[0]), paused[1])
