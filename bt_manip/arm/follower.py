"""The reference of an arm: trajectory following, time scaling, pause and stop."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotModel
from bt_manip.trajectories import (
    CONTROL_STEP,
    Samples,
    TimeScaledTrajectory,
    Trajectory,
    change_speed_scale,
    plan_stop,
    sample_times,
    time_scaling_state,
    tool_use,
    trajectory_from_state,
)

PATH_SPACING = 0.02  # [rad] between the configurations that are kept of a travelled path
SENT_AHEAD = 500  # setpoints of a motion that a real arm gets, before a stop planned ahead
PATH_MEMORY = 64  # configurations that are kept: 1.3 rad of the joint that moves most


class ArmState(NamedTuple):
    """The state of an arm's reference, and the trajectory that it follows."""

    q: np.ndarray  # [rad]  (nq,)
    v: np.ndarray  # [rad/s]  (nq,)
    a: np.ndarray  # [rad/s2]  (nq,)
    trajectory: Trajectory | None  # None at rest
    time: float  # [s] since the start of the trajectory
    speed_scale: float  # as commanded, 0 to 1
    stopping: bool  # whether the trajectory is a stop that discards the motion
    blend_radius: float = 0.0  # [m] of the tool around its target, where the next motion may begin

    @property
    def at_rest(self) -> bool:
        """Whether velocity and acceleration are zero."""
        return not (self.v.any() or self.a.any())

    @property
    def target(self) -> np.ndarray:
        """Configuration in which the arm will come to rest [rad]."""  # (nq,)
        return self.q if self.trajectory is None else self.trajectory.end


class PlannedMotion(NamedTuple):
    """A trajectory to follow, starting from the present reference.

    Attributes:
        trajectory: The trajectory at the present speed scale; at speed scale 0 and at rest, the
            unscaled one, which starts when the scale is raised.
        stops: Whether it is only a stop.
        lagging: Whether the speed scale is to be changed again later, because the limits do not
            allow the full change now.
    """

    trajectory: Trajectory
    stops: bool = False
    lagging: bool = False


class TrajectoryFollower:
    """Own the reference of an arm and advance it along trajectories.

    Scaling the time of a trajectory changes its speed, pauses it and stops it without leaving its
    path.

    Args:
        q: Configuration at which the arm rests at first [rad].  # (nq,)

    Attributes:
        q: Position [rad], read-only and live.  # (nq,)
        v: Velocity [rad/s], read-only and live.  # (nq,)
        a: Acceleration [rad/s2], read-only and live.  # (nq,)
        trajectory: The trajectory being followed; None at rest.
        paused: A paused trajectory and the time in it [s]; None when nothing is paused.
        speed_scale: Commanded speed scale, 0 to 1.
        stopping: Whether the trajectory is a stop that discards the motion.
        lagging: Whether the limits have not allowed (all of) the last change of the speed scale.
        step: Control steps since the trajectory was last sampled.
        dt: Duration of a control step, as of the last one [s].
        latency: Control steps from now until a change of the motion takes effect; 0 in simulation.
            It is set while a change is requested, which is planned from the state at that time.
        send: Called before a change is made, with the latency and the positions from there on,
            which end in a stop; an exception leaves the motion as it was.  # (n, nq) [rad]
    """

    latency = 0
    send: Callable[[int, np.ndarray], None] | None = None

    def __init__(self, q: np.ndarray) -> None:
        self._now = np.zeros(3 * len(q))  # flat, because that is copied faster
        live = self._now.reshape(3, -1)
        live.setflags(write=False)
        self.q, self.v, self.a = live
        self.reset(q)

    def reset(self, q: np.ndarray) -> None:
        """Discard all motion and rest at a configuration [rad], at speed scale 1."""
        self.hold_at(q)
        self.paused: tuple[Trajectory, float] | None = None
        self.speed_scale = 1.0
        self._start = 0.0  # [s] in the trajectory, of the first sample
        self.dt = CONTROL_STEP
        self._setpoints = np.empty((0, 3 * len(q)))
        self._travelled = np.array([q])
        self.step = self._last = 0

    def hold_at(self, q: np.ndarray) -> None:
        """Rest at another configuration from now on [rad], without a motion there."""
        self._now[:] = 0.0
        self._now[: len(q)] = q
        self.trajectory: Trajectory | None = None
        self.stopping = self.lagging = False

    @property
    def state(self) -> ArmState:
        """The state when a change takes effect; of the present one the arrays are live."""
        if self.latency and self.trajectory is not None:
            return self._state_ahead()
        return ArmState(
            self.q, self.v, self.a, self.trajectory, self.time, self.speed_scale, self.stopping
        )

    @property
    def time(self) -> float:
        """Time since the start of the trajectory [s]."""
        return self._start + self.step * self.dt

    @property
    def remaining(self) -> float:
        """Time until the reference comes to rest [s]."""
        return 0.0 if self.trajectory is None else max(0.0, self.trajectory.duration - self.time)

    @property
    def travelled(self) -> np.ndarray:
        """The path just travelled, oldest first, about `PATH_SPACING` apart [rad]."""  # (n, nq)
        setpoints = self._setpoints[: self.step + 1, : len(self.q)]
        # Distances add up from the last configuration that was kept.
        path = np.concatenate([self._travelled[-1:], setpoints])
        steps = np.abs(np.diff(path, axis=0)).max(axis=1)
        marks = np.floor(np.cumsum(steps) / PATH_SPACING)
        kept = setpoints[np.diff(marks, prepend=0.0) > 0.0]
        return np.concatenate([self._travelled, kept])[-PATH_MEMORY:]

    def ahead(self, times: np.ndarray) -> np.ndarray:
        """Return the reference positions at times from now on [rad]."""  # (n,) -> (n, nq)
        trajectory = self.trajectory
        if trajectory is None:
            return np.tile(self.q, (len(times), 1))
        if self.send is not None:  # the trajectory may begin later
            steps = self.step + np.rint(times / self.dt).astype(int)
            return self._setpoints[np.minimum(steps, self._last), : len(self.q)]
        return trajectory.sample(np.minimum(self.time + times, trajectory.duration))[0]

    def follow(self, motion: PlannedMotion | None, model: RobotModel) -> None:
        """Follow a planned motion instead of the present one.

        Args:
            motion: The motion; None discards a paused motion and changes nothing else.
            model: The arm with its payload.

        Raises:
            MotionError: When it exceeds a limit; then nothing changes.
        """
        if motion is None:
            self.paused = None
        elif self.speed_scale == 0.0 and self.state.at_rest:
            self._checked(motion.trajectory, model)
            self.paused, self.lagging = (motion.trajectory, 0.0), False
            self._let_end()
        else:
            self._take(motion.trajectory, model)
            self.paused, self.stopping, self.lagging = None, motion.stops, motion.lagging

    def stop(self, model: RobotModel) -> None:
        """Stop on the path as soon as the limits allow, and discard the motion."""
        self.paused, self.lagging = None, False
        if self.trajectory is None or (state := self.state).at_rest:
            self._let_end()
            return
        self._take(plan_stop(self.trajectory, state.time, model), model)
        self.stopping = True

    def set_speed_scale(self, speed_scale: float, model: RobotModel) -> None:
        """Change the speed scale; 0 pauses.

        Where the limits do not allow that now, the motion continues as it was and `lagging` is set.
        A motion that was planned for a faster tool becomes slower than that.

        Raises:
            MotionError: When the motion would take too long; then nothing changes.
        """
        change: tuple[Trajectory, tuple[float, float, float]] | None = None
        scale = speed_scale
        state, paused = self.state, self.paused
        if self.trajectory is not None and state.trajectory is None and not self.stopping:
            paused = _pause_at_end(self.trajectory)  # it rests by then
        elif paused is not None and state.trajectory is not None:
            self.latency = self._last - self.step  # from rest only
        if paused is not None:
            if speed_scale > 0.0:
                nominal, s = paused
                scale = _kept_scale(nominal, s, speed_scale, model)
                # At its start a trajectory itself accelerates from rest.
                change = nominal, (s, 0.0 if s else scale, 0.0)
        elif state.trajectory is not None and not self.stopping:
            change = time_scaling_state(state.trajectory, state.time)
            scale = _kept_scale(change[0], change[1][0], speed_scale, model)
        lagging = False
        if change is not None:
            found = change_speed_scale(*change, scale, model)
            if found is not None:
                self._take(found.trajectory, model)
                self.paused, self.stopping = None, False
            lagging = found is None or not found.near_optimal
        self.speed_scale, self.lagging = speed_scale, lagging

    def advance(self, dt: float) -> None:
        """Advance the reference by a control step [s]."""
        if self.trajectory is None:
            return
        if dt != self.dt:
            self._start, self.dt = self.time, dt
            self._sample()
        self.step = step = self.step + 1
        self._now[...] = self._setpoints[step]
        if step == self._last:
            self._end()

    def get_state(self) -> dict[str, Any]:
        """Return everything as plain data."""
        trajectory, paused = self.trajectory, self.paused
        return {
            "q_v_a": self._now.tolist(),
            "trajectory": None if trajectory is None else trajectory.get_state(),
            "start": self._start,
            "dt": self.dt,
            "step": self.step,
            "speed_scale": self.speed_scale,
            "stopping": self.stopping,
            "lagging": self.lagging,
            "paused": None if paused is None else [paused[0].get_state(), paused[1]],
            "travelled": (self.travelled if trajectory is None else self._travelled).tolist(),
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore what `get_state` returned; it continues bit for bit."""
        self._now[:] = state["q_v_a"]
        trajectory, paused = state["trajectory"], state["paused"]
        self.trajectory = None if trajectory is None else trajectory_from_state(trajectory)
        self._start, self.dt = state["start"], state["dt"]
        self._setpoints = self._setpoints[:0]
        if self.trajectory is not None:
            self._sample()
        self.step, self._travelled = state["step"], np.array(state["travelled"])
        self.speed_scale, self.stopping = state["speed_scale"], state["stopping"]
        self.lagging = state["lagging"]
        self.paused = None if paused is None else (trajectory_from_state(paused[0]), paused[1])

    def _take(self, trajectory: Trajectory, model: RobotModel) -> None:
        """Follow a trajectory from its start, if it is inside the limits."""
        setpoints = self._checked(trajectory, model)
        if self.latency:
            self._take_later(trajectory, np.concatenate(setpoints, axis=1), model)
            return
        self.trajectory, self._start = trajectory, 0.0
        if self.dt == CONTROL_STEP:
            self._keep(setpoints)
        else:
            self._sample()

    def _take_later(self, trajectory: Trajectory, setpoints: np.ndarray, model: RobotModel) -> None:
        """Follow a trajectory after the latency."""
        latency, n = self.latency, len(self.q)
        before = self._now[np.newaxis]
        if self.trajectory is not None:
            before = self._setpoints[self.step : self.step + latency]
        rest = np.repeat(before[-1:], latency - len(before[:latency]), axis=0)
        rest[:, n:] = 0.0
        joined = np.concatenate([before[:latency], rest, setpoints])
        start = -latency * self.dt
        if self.send is not None:
            self.send(latency, _with_stop(joined[latency:, :n], trajectory, 0.0, model))
        self._travelled = self.travelled
        self.trajectory, self._start, self._setpoints = trajectory, start, joined
        self.step, self._last = 0, len(joined) - 1

    def send_on(self, latency: int, model: RobotModel) -> bool:
        """Send what follows of the motion after a latency; return whether it goes on beyond that.

        Raises:
            Exception: Any of `send`.
        """
        begin = self.step + latency
        if self.trajectory is None or self.send is None or begin >= self._last:
            return False
        setpoints = self._setpoints[begin:, : len(self.q)]
        time = self._start + begin * self.dt
        sent = _with_stop(setpoints, self.trajectory, time, model)
        self.send(latency, sent)
        return sent is not setpoints

    def _state_ahead(self) -> ArmState:
        """Return the state after the latency."""
        step = self.step + self.latency
        q, v, a = self._setpoints[min(step, self._last)].reshape(3, -1)
        trajectory, time = self.trajectory, self._start + step * self.dt
        if step >= self._last:
            v, a, trajectory, time = np.zeros_like(q), np.zeros_like(q), None, 0.0
        return ArmState(q, v, a, trajectory, max(time, 0.0), self.speed_scale, self.stopping)

    def _let_end(self) -> None:
        """Drop a trajectory that is at rest when a change takes effect."""
        if self.latency and self.trajectory is not None:
            self.stopping = True  # it does not pause at its end
        else:
            self.trajectory, self.stopping = None, False

    def _checked(self, trajectory: Trajectory, model: RobotModel) -> Samples:
        """Return the samples of a trajectory at all control steps.

        Raises:
            MotionError: When it exceeds a limit. Positions may stay beyond theirs by as much as the
                present one is.
        """
        setpoints = trajectory.sample(sample_times(trajectory.duration, CONTROL_STEP))
        use = model.limits.use(*setpoints)
        if not use._replace(position=0.0).inside:
            raise MotionError(f"the planned motion exceeds a limit: {use}", reason="limits")
        if problem := model.limits.leaving(setpoints[0]):
            raise MotionError(f"the planned motion leaves its bounds: {problem}", reason="limits")
        return setpoints

    def _end(self) -> None:
        """Rest at the end of the trajectory, or paused in the middle of it."""
        ended, self.trajectory = self.trajectory, None
        if ended is not None and not self.stopping:
            self.paused = _pause_at_end(ended)
        self.stopping = False
        self.lagging = self.paused is not None and self.speed_scale > 0.0  # resumed meanwhile

    def _sample(self) -> None:
        """Sample the rest of the trajectory at once, so that a control step copies one setpoint."""
        assert self.trajectory is not None
        times = self._start + sample_times(self.trajectory.duration - self._start, self.dt)
        self._keep(self.trajectory.sample(times))

    def _keep(self, setpoints: Samples) -> None:
        self._travelled = self.travelled
        self._setpoints = np.concatenate(setpoints, axis=1)
        self.step, self._last = 0, len(self._setpoints) - 1


def _pause_at_end(trajectory: Trajectory) -> tuple[Trajectory, float] | None:
    """Return the trajectory that is paused at the end of another one, and the time in it [s]."""
    if isinstance(trajectory, TimeScaledTrajectory) and not trajectory.complete:
        return trajectory.nominal, trajectory.time_scaling.end
    return None


def _kept_scale(trajectory: Trajectory, s: float, scale: float, model: RobotModel) -> float:
    """Return a speed scale for the rest of a trajectory, reduced where the tool is too fast."""
    return scale / max(1.0, scale * tool_use(trajectory, model.limits, s))


def _with_stop(q: np.ndarray, trajectory: Trajectory, time: float, model: RobotModel) -> np.ndarray:
    """Return the first `SENT_AHEAD` setpoints of a motion from a time on, and a stop after them."""
    if len(q) <= SENT_AHEAD + 1:
        return q
    stop = plan_stop(trajectory, time + SENT_AHEAD * CONTROL_STEP, model)
    after = stop.sample(sample_times(stop.duration, CONTROL_STEP))[0]
    return np.concatenate([q[:SENT_AHEAD], after])
