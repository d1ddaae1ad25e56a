"""Detection of external forces on the arm, by direct estimation of the external joint torque."""

from operator import le
from typing import Any, NamedTuple

import numpy as np

from bt_manip.robots import Robot, RobotModel

CHECK_INTERVAL = 7  # control steps between two checks
CONSECUTIVE_DETECTIONS = 2  # checks in a row in which sustained contact has to exceed the threshold
TORQUE_THRESHOLD = 0.03  # of a joint's effort limit; about 10 N at the Panda's hand
FORCE_THRESHOLD = 1.2  # [N] at the tool, if its torque is larger: weak arms meet that in handling
FRICTION_MARGIN = 2.2  # of a joint's dry friction, whose sign is uncertain near rest
INITIAL_MARGIN = 1.5  # of the external torque that is present when a motion begins
IMPULSE_THRESHOLD = 7e-3  # [s] in which the torque threshold makes the threshold of the impulse
IMPULSE_THRESHOLD_WITH_PAYLOAD = 12e-3  # [s] the same with a payload, which may slip in the grip


class ExternalLoad(NamedTuple):
    """External joint torques, or impulses of an impact.

    Attributes:
        values: Of each joint [N m or N m s].  # (nq,)
        thresholds: Values from which they are contacts [N m or N m s].  # (nq,)
        impact: Whether they are impulses.
    """

    values: np.ndarray
    thresholds: np.ndarray
    impact: bool = False

    @property
    def exceeding(self) -> np.ndarray:
        """Which values exceed their thresholds."""  # (nq,)
        return np.abs(self.values) > self.thresholds

    @property
    def exceeded(self) -> bool:
        """Whether a value exceeds its threshold."""
        return bool(self.exceeding.any())

    def __str__(self) -> str:
        """Return the largest value relative to its threshold."""
        quantity, unit, digits = ("impulse", "N m s", 2) if self.impact else ("torque", "N m", 1)
        joint = int((np.abs(self.values) / self.thresholds).argmax())
        article = "an" if self.impact else "a"
        return (
            f"{article} {quantity} of {abs(self.values[joint]):.{digits}f} {unit} at joint "
            f"{joint + 1} (threshold {self.thresholds[joint]:.{digits}f} {unit})"
        )


class Detection(NamedTuple):
    """A detected external force.

    Attributes:
        load: Its torques or impulses at the joints.
        following: Whether the controller has followed the reference before: the motor torque was
            about what that takes.
    """

    load: ExternalLoad
    following: bool = True


def external_load(robot: Robot, model: RobotModel) -> ExternalLoad:
    """Return the external joint torques in the last step, uncertain by the dry friction.

    Args:
        robot: The robot with its measured motion and motor torques.
        model: The arm with its payload.
    """
    if robot.read_tau_external is not None:
        return ExternalLoad(robot.read_tau_external(), torque_thresholds(model))
    dt, a = float(robot.mj_model.opt.timestep), robot.a
    q, v = robot.q - dt * robot.v, robot.v - dt * a  # of that step: an oscillating arm changes fast
    torque = model.rnea(q, v, a) + model.damping * v - robot.tau
    return ExternalLoad(torque, torque_thresholds(model))


def torque_thresholds(model: RobotModel) -> np.ndarray:
    """Return the external torque of each joint from which it is a contact [N m]."""  # (nq,)
    threshold = np.maximum(TORQUE_THRESHOLD * model.limits.effort, FORCE_THRESHOLD * model.levers)
    return threshold + FRICTION_MARGIN * model.friction


class ExternalForceGuard:
    """Detects sustained contacts and impacts from measured motion and motor torques.

    The external joint torque is estimated directly as inverse dynamics of the measured motion, plus
    friction, minus motor torque; a sustained contact exceeds its threshold in consecutive checks.
    An impact may be over before a check, but changes the velocity error against the reference: the
    inertia matrix times that change since the last check, less what the motors contributed, is its
    impulse. Motor torques are held for a control step, so the arm lags changes of the reference
    acceleration by half a step; the impulse of that is subtracted too. External torques that are
    present when a motion begins, such as from a table under a gripped object, are tolerated. A real
    arm that knows no external torques is not guarded: see `measures`.

    Args:
        robot: The robot with its measured motion and motor torques.
        model: Its model, for friction and effort limits.

    Attributes:
        thresholds: External torque of each joint from which it is a contact [N m].  # (nq,)
    """

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        self._robot = robot
        self.thresholds = torque_thresholds(model)
        self._tolerate(self.thresholds)
        self._detections = 0
        self._last = _Measurement(*np.zeros((5, model.nq)))

    @property
    def measures(self) -> bool:
        """Whether external torques are known; a real arm may know none."""
        measured = self._robot.read_tau_external
        return measured is None or not np.isnan(measured()).any()

    def begin(self, model: RobotModel, v_ref: np.ndarray, a_ref: np.ndarray) -> None:
        """Tolerate the external torques that are present when a motion begins.

        Args:
            model: The arm with its payload.
            v_ref: Reference velocity [rad/s].  # (nq,)
            a_ref: Reference acceleration [rad/s2].  # (nq,)
        """
        if self._robot.read_tau_external is not None:
            torque = np.abs(self._robot.read_tau_external())
        else:
            self._last = now = self._measure(model, v_ref, a_ref)
            torque = np.abs(model.rnea(now.q, now.v, self._robot.a) - now.tau)
        present = np.maximum(torque - model.friction, 0.0)  # friction is in the thresholds
        self._tolerate(self.thresholds + INITIAL_MARGIN * present)
        self._detections = 0

    def check(
        self, model: RobotModel, v_ref: np.ndarray, a_ref: np.ndarray, dt: float
    ) -> Detection | None:
        """Check the last control step for contact, and those since the last check for an impact.

        Args:
            model: The arm with its payload.
            v_ref: Reference velocity after that step [rad/s].  # (nq,)
            a_ref: Reference acceleration after that step [rad/s2].  # (nq,)
            dt: Duration of a control step [s].

        Returns:
            The detected force; None when there is none.
        """
        if self._robot.read_tau_external is not None:
            return self._sustained(self._robot.read_tau_external()) if self.measures else None
        before, now = self._last, self._measure(model, v_ref, a_ref)
        self._last, a = now, self._robot.read_a()
        inverse_dynamics = model.rnea(now.q, now.v, a)
        torque = inverse_dynamics - now.tau
        change = model.rnea(now.q, now.v, a + (now.v_error - before.v_error)) - inverse_dynamics
        threshold, bounds = self._bounds[bool(model.payload)]
        # Compared one by one: for so few numbers NumPy is slower.
        if all(map(le, map(abs, change.tolist() + torque.tolist()), bounds)):
            self._detections = 0
            return None
        if not (np.abs(change) <= threshold).all():
            impulse = _external_impulse(change, before, now, model, dt)
            if (np.abs(impulse) > threshold).any():
                joint = int((np.abs(impulse) / threshold).argmax())
                motors = CHECK_INTERVAL * dt * abs(before.corrective(model)[joint])
                load = ExternalLoad(impulse, threshold, impact=True)
                return Detection(load, following=motors < abs(impulse[joint]))
        return self._sustained(torque)

    def _sustained(self, torque: np.ndarray) -> Detection | None:
        """Return external torques [N m] that have exceeded the tolerated ones in a row."""
        within = (np.abs(torque) <= self._tolerated).all()  # NaN is not
        self._detections = 0 if within else self._detections + 1
        if self._detections < CONSECUTIVE_DETECTIONS:
            return None
        return Detection(ExternalLoad(torque, self._tolerated))

    def get_state(self) -> dict[str, Any]:
        """Return the state between checks as plain data."""
        return {
            "tolerated": self._tolerated.tolist(),
            "detections": self._detections,
            "last": [part.tolist() for part in self._last],
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore what `get_state` returned."""
        self._tolerate(np.array(state["tolerated"]))
        self._detections = state["detections"]
        self._last = _Measurement(*(np.array(part) for part in state["last"]))

    def _tolerate(self, torques: np.ndarray) -> None:
        self._tolerated = torques
        impulses = (IMPULSE_THRESHOLD * torques, IMPULSE_THRESHOLD_WITH_PAYLOAD * torques)
        self._bounds = [(limit, limit.tolist() + torques.tolist()) for limit in impulses]

    def _measure(self, model: RobotModel, v_ref: np.ndarray, a_ref: np.ndarray) -> "_Measurement":
        robot, v = self._robot, self._robot.read_v()
        tau = robot.read_tau() - model.damping * v
        return _Measurement(robot.read_q().copy(), v.copy(), v - v_ref, a_ref.copy(), tau)


class _Measurement(NamedTuple):
    """A measured state; each of shape (nq,)."""

    q: np.ndarray  # [rad]
    v: np.ndarray  # [rad/s]
    v_error: np.ndarray  # [rad/s] v minus the reference velocity
    a_ref: np.ndarray  # [rad/s2]
    tau: np.ndarray  # [N m] motor torque minus damping

    def corrective(self, model: RobotModel) -> np.ndarray:
        """Return the motor torque beyond that of the reference acceleration [N m]."""
        return self.tau - model.rnea(self.q, self.v, self.a_ref)


def _external_impulse(
    change: np.ndarray, before: _Measurement, now: _Measurement, model: RobotModel, dt: float
) -> np.ndarray:
    """Return the part of a change of momentum that the motors have not made [N m s]."""  # (nq,)
    time, still = CHECK_INTERVAL * dt, np.zeros_like(now.v)
    lag = model.rnea(now.q, still, 0.5 * dt * (before.a_ref - now.a_ref))
    lag -= model.rnea(now.q, still, still)
    sign = np.sign(change)
    motors = np.maximum(
        sign * (time * before.corrective(model)), sign * (time * now.corrective(model))
    ).clip(min=0.0)
    motors += (sign * lag).clip(min=0.0)
    return change - sign * np.minimum(motors, np.abs(change))
