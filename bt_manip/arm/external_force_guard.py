"""Notice that something pushes the arm."""

from operator import le
from typing import Any, NamedTuple

import numpy as np

from bt_manip.robots import Robot, RobotModel

EVERY = 7  # control steps between two looks
PATIENCE = 2  # looks in a row in which a joint takes too much
LASTING = 7e-3  # [s] a blow is one that a tolerated effort would take longer for
CARRYING = 12e-3  # [s] the same with something held, which gives way between the fingers
SHARE = 0.03  # of a joint's effort limit that an unmeant effort has to exceed
AT_FIRST = 1.5  # times what presses on it when a motion begins
FRICTION = 2.2  # of a joint's dry friction, whose direction is uncertain around rest


class ExternalForceGuard:
    """Compares the efforts that make the arm move as it does with those of its motors.

    What is left of ``M a + bias - tau``, friction apart, is what others do to the arm: a push, or a
    contact. For the Panda the bounds are about what 10 N at its hand make. A blow is over before
    anybody looks, but it leaves the arm at another velocity than that of its reference: ``M`` times
    what came to that difference since the last look is the blow's impulse, as far as the motors did
    not make it. A controller that follows badly makes much of it, and always towards the
    difference; one that follows well only works against it. Efforts are held through a control
    step, so where the reference's acceleration changes within a few of them, as halfway through a
    short motion, the arm falls behind by half a step of that change; this is no blow either.

    What presses on the arm already when a motion begins, as a table on what is gripped from it, is
    no deviation of that motion.

    Attributes:
        bounds: Largest effort of each joint that is no deviation [N m].  # (nq,)
    """

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        """Watch a robot.

        Args:
            robot: Its measured positions, velocities, accelerations and efforts are looked at.
            model: Its friction and its limits.
        """
        self._robot = robot
        self.bounds = SHARE * model.limits.effort + FRICTION * model.friction
        self._tolerate(self.bounds)
        self._strikes = 0
        self._last = _Moment(*np.zeros((5, model.nq)))

    def begin(self, model: RobotModel, v_ref: np.ndarray, a_ref: np.ndarray) -> None:
        """Tolerate what there is when a motion begins.

        Args:
            model: The arm with its payload.
            v_ref: Velocity of its reference [rad/s].  # (nq,)
            a_ref: Acceleration of its reference [rad/s2].  # (nq,)
        """
        self._last = now = self._moment(model, v_ref, a_ref)
        effort = np.abs(model.rnea(now.q, now.v, self._robot.a) - now.commanded)
        # The bounds know of friction already.
        self._tolerate(self.bounds + AT_FIRST * np.maximum(effort - model.friction, 0.0))
        self._strikes = 0

    def _tolerate(self, efforts: np.ndarray) -> None:
        self._tolerated, self._presses = efforts, efforts.tolist()
        self._blows = [(lasting * efforts).tolist() for lasting in (LASTING, CARRYING)]

    def look(self, model: RobotModel, v_ref: np.ndarray, a_ref: np.ndarray, dt: float) -> str:
        """Look at the last control step, and at what has come of those since the last look.

        Args:
            model: The arm with its payload.
            v_ref: Velocity of its reference after that step [rad/s].  # (nq,)
            a_ref: Acceleration of its reference after that step [rad/s2].  # (nq,)
            dt: Duration of a control step [s].

        Returns:
            What is wrong, once it is so for long enough; empty otherwise.
        """
        before, now = self._last, self._moment(model, v_ref, a_ref)
        self._last, a = now, self._robot.a
        needed = model.rnea(now.q, now.v, a)
        change = model.rnea(now.q, now.v, a + (now.error - before.error)) - needed
        effort = needed - now.commanded
        if not _inside(change, self._blows[bool(model.payload)]):
            blow = self._blow(change, before, now, model, dt)
            if blow:
                return blow
        self._strikes = 0 if _inside(effort, self._presses) else self._strikes + 1
        if self._strikes < PATIENCE:
            return ""
        joint = int((np.abs(effort) / self._tolerated).argmax())
        return (
            f"something pushes the arm: joint {joint + 1} takes {abs(effort[joint]):.1f} N m that "
            f"are not of its motion ({self._tolerated[joint]:.1f} N m are tolerated)"
        )

    def _blow(
        self,
        change: np.ndarray,
        before: "_Moment",
        now: "_Moment",
        model: RobotModel,
        dt: float,
    ) -> str:
        """Say what has struck the arm between two looks; empty where its motors explain it."""
        time = EVERY * dt
        tolerated = (CARRYING if model.payload else LASTING) * self._tolerated
        late = model.rnea(now.q, np.zeros_like(now.v), 0.5 * dt * (before.a_ref - now.a_ref))
        late -= model.rnea(now.q, np.zeros_like(now.v), np.zeros_like(now.v))
        impulse = _unexplained(change, time * before.astray(model), time * now.astray(model), late)
        blow = np.abs(impulse) / tolerated
        if not blow.max() > 1.0:
            return ""
        joint = int(blow.argmax())
        return (
            f"something pushes the arm: joint {joint + 1} takes {abs(impulse[joint]):.2f} "
            f"N m s at once ({tolerated[joint]:.2f} N m s are tolerated)"
        )

    def _moment(self, model: RobotModel, v_ref: np.ndarray, a_ref: np.ndarray) -> "_Moment":
        robot = self._robot
        v = robot.v
        return _Moment(robot.q, v, v - v_ref, a_ref.copy(), robot.tau - model.damping * v)

    def get_state(self) -> dict[str, Any]:
        """Give what is remembered between looks as plain data."""
        return {
            "tolerated": self._tolerated.tolist(),
            "strikes": self._strikes,
            "last": [part.tolist() for part in self._last],
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Take back what `get_state` gave."""
        self._tolerate(np.array(state["tolerated"]))
        self._strikes = state["strikes"]
        self._last = _Moment(*(np.array(part) for part in state["last"]))


class _Moment(NamedTuple):
    """What was seen at a look; each of shape (nq,)."""

    q: np.ndarray  # [rad]
    v: np.ndarray  # [rad/s]
    error: np.ndarray  # [rad/s] of the velocity, against that of the reference
    a_ref: np.ndarray  # [rad/s2]
    commanded: np.ndarray  # [N m] what the motors make, without what damping takes of it

    def astray(self, model: RobotModel) -> np.ndarray:
        """Give the effort by which the motors accelerate the arm away from its reference [N m]."""
        return self.commanded - model.rnea(self.q, self.v, self.a_ref)


def _inside(numbers: np.ndarray, bounds: list[float]) -> bool:
    """Tell whether no number exceeds its bound."""
    # One by one: for so few numbers NumPy takes longer to begin.
    return all(map(le, map(abs, numbers.tolist()), bounds))


def _unexplained(
    change: np.ndarray, before: np.ndarray, after: np.ndarray, late: np.ndarray
) -> np.ndarray:
    """Give what is left of a change of momentum without what the motors made of it [N m s].

    Args:
        change: The change.  # (nq,)
        before: What the motors would have made, going on as at the last look.  # (nq,)
        after: What they would have made, had they always been as they are now.  # (nq,)
        late: What it costs that efforts are held through a step while the reference's acceleration
            changes: the arm has that of half a step before.  # (nq,)
    """
    towards = np.sign(change)
    made = np.maximum(towards * before, towards * after).clip(min=0.0)
    made += (towards * late).clip(min=0.0)
    return change - towards * np.minimum(made, np.abs(change))
