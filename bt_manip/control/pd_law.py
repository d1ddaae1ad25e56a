"""PD control with gravity compensation, its default gains, and checks of gains."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from pinocchio import computeMinverse

from bt_manip.robots import RobotModel

from .exceptions import ControlError

POSITION_GAIN = 15.0
"""Default position gain over effort limit [1/rad]: the motor saturates at an error of 67 mrad."""

VELOCITY_GAIN = 0.6
"""Default velocity gain over effort limit [s/rad]: the motor saturates at 1.7 rad/s."""

MAX_DECAY = 500.0
"""Largest default velocity gain over inertia of a joint [1/s]: with steps of 1 ms the velocity
error halves in a step; from four times this on it would oscillate and grow."""

COMPLIANT_POSITION_GAIN = 5.0
"""Position gain of a compliant arm over effort limit [1/rad]: a third of the default."""

COMPLIANT_FREQUENCY = 100.0
"""Largest natural frequency of a compliant joint [rad/s]: a tenth of the control rate."""

_CONFIGURATIONS = 16  # number of configurations at which the inertia is computed, besides home


def default_gains(model: RobotModel) -> tuple[np.ndarray, np.ndarray]:
    """Return default position and velocity gains [N m/rad, N m s/rad].

    They are proportional to the effort limits. For joints that are too light, both are reduced by
    the same factor, so that the velocity gain is `MAX_DECAY` times the smallest inertia.

    Args:
        model: The arm with its payload.
    """  # (nv,), (nv,)
    kd = VELOCITY_GAIN * model.limits.effort
    share = np.minimum(1.0, MAX_DECAY * smallest_inertia(inverse_inertias(model)) / kd)
    return POSITION_GAIN * model.limits.effort * share, kd * share


def pd_torque(
    model: RobotModel,
    kp: np.ndarray,
    kd: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    q_ref: np.ndarray,
    v_ref: np.ndarray,
) -> np.ndarray:
    """Return ``kp (q_ref - q) + kd (v_ref - v) + g(q)`` [N m].

    Args:
        model: The arm with its payload.
        kp: Position gains [N m/rad].  # (nv,)
        kd: Velocity gains [N m s/rad].  # (nv,)
        q: Measured positions [rad].  # (nv,)
        v: Measured velocities [rad/s].  # (nv,)
        q_ref: Reference positions [rad].  # (nv,)
        v_ref: Reference velocities [rad/s].  # (nv,)
    """  # (nv,)
    gravity = pin.computeGeneralizedGravity(model.model, model.data, q)
    return kp * (q_ref - q) + kd * (v_ref - v) + gravity


def compliant_torque(
    model: RobotModel, effort: np.ndarray, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray
) -> np.ndarray:
    """Return soft, critically damped springs to a resting reference, plus gravity [N m].

    Args:
        model: The arm with its payload.
        effort: Effort limits [N m].  # (nv,)
        q: Measured positions [rad].  # (nv,)
        v: Measured velocities [rad/s].  # (nv,)
        q_ref: Reference positions [rad].  # (nv,)
    """  # (nv,)
    inertia = np.diagonal(pin.crba(model.model, model.data, q))
    stiffness = np.minimum(COMPLIANT_POSITION_GAIN * effort, COMPLIANT_FREQUENCY**2 * inertia)
    damping = 2.0 * np.sqrt(stiffness * inertia)
    return pd_torque(model, stiffness, damping, q, v, q_ref, np.zeros_like(v))


def gain_array(
    name: str, gain: float | Sequence[float] | np.ndarray, n: int, of: str = "joints"
) -> np.ndarray:
    """Return one gain for each joint or axis.

    Args:
        name: Name of the gain, for the message.
        gain: One number for all, or one for each.
        n: Number of gains.
        of: Plural of the elements with gains, for the message.

    Raises:
        ControlError: If a gain is negative or not finite, or their number is wrong.
    """  # (n,)
    gains = np.array(gain, dtype=float)
    if gains.shape not in ((), (n,)):
        raise ControlError(f"{name} is one number, or one for each of {n} {of}, got {gain!r}")
    if not np.isfinite(gains).all() or (gains < 0).any():
        raise ControlError(f"{name} must be finite and not negative, got {gain!r}")
    return np.full(n, gains)


def inverse_inertias(model: RobotModel) -> np.ndarray:
    """Return the inverse inertia matrices of an arm at home and at random configurations.

    Args:
        model: The arm with its payload.
    """  # (k, nv, nv) [1/(kg m2)]
    rng = np.random.default_rng(0)
    lower, upper = model.limits.sampling_bounds()
    samples = [model.home, *rng.uniform(lower, upper, (_CONFIGURATIONS, model.nq))]
    return np.array([computeMinverse(model.model, model.data, q) for q in samples])


def smallest_inertia(inverses: np.ndarray) -> np.ndarray:
    """Return the smallest inertia at each motor while the other joints move freely.

    Args:
        inverses: Result of `inverse_inertias`.
    """  # (nv,) [kg m2]
    return 1.0 / np.diagonal(inverses, axis1=1, axis2=2).max(axis=0)
