"""How light the joints of an arm are, which bounds the gains of feedback."""

import numpy as np
from pinocchio import computeMinverse

from bt_manip.robots import RobotModel

_CONFIGURATIONS = 16  # at which the inertia is computed, beside home


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
    """Return the smallest inertia that a motor feels while the other joints give way.

    Args:
        inverses: As `inverse_inertias` returns them.
    """  # (nv,) [kg m2]
    return 1.0 / np.diagonal(inverses, axis1=1, axis2=2).max(axis=0)
