"""The shortest time that a path can be driven in, computed by TOPP-RA (the package toppra).

H. Pham, Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability
Analysis", IEEE T-RO 34 (2018). It knows limits of velocity, acceleration and torque, and none of
jerk: nothing that keeps these can be faster, and what keeps a limit of jerk too is slower.
"""

import logging

import numpy as np

from bt_manip.motion import PathTrajectory, SequenceTrajectory, Trajectory
from bt_manip.motion.paths import Path
from bt_manip.robots import RobotModel

GRID = 400  # intervals


def missing() -> str:
    """Say what to install where toppra is not there; empty where it is."""
    try:
        import toppra  # noqa: F401
    except ImportError as error:
        return f"{error}; 'pip install toppra' brings it"
    return ""


def fastest_time(trajectory: Trajectory, model: RobotModel) -> float:
    """Give the time-optimal duration of the path that a trajectory from rest to rest drives [s].

    All limits are taken in full, the efforts' too.
    """
    if isinstance(trajectory, SequenceTrajectory):
        return sum(fastest_time(part, model) for part in trajectory.parts)
    assert isinstance(trajectory, PathTrajectory)
    return _fastest(trajectory.path, model)


def _fastest(path: Path, model: RobotModel) -> float:
    import toppra
    from toppra import algorithm, constraint

    logging.getLogger("toppra").setLevel(logging.ERROR)

    class Geometry(toppra.interpolator.AbstractGeometricPath):
        dof = path.nq
        path_interval = np.array([0.0, 1.0])
        waypoints = None

        def __call__(self, places, order=0):
            places = np.asarray(places, dtype=float)
            found = path.evaluate(np.atleast_1d(places), order)[order][:, : path.nq]
            return found[0] if places.ndim == 0 else found

    def inverse_dynamics(q, v, a):
        return model.rnea(q, v, a) + model.damping * v

    def both(limit):
        return np.column_stack([-limit, limit])

    limits = model.limits
    constraints = [
        constraint.JointVelocityConstraint(both(limits.velocity)),
        constraint.JointAccelerationConstraint(both(limits.acceleration)),
        constraint.JointTorqueConstraint(
            inverse_dynamics,
            both(limits.effort),
            model.friction,
            discretization_scheme=constraint.DiscretizationType.Collocation,
        ),
    ]
    places = np.linspace(0.0, 1.0, GRID + 1)
    solver = algorithm.TOPPRA(
        constraints, Geometry(), gridpoints=places, parametrizer="ParametrizeConstAccel"
    )
    return float(solver.compute_trajectory(0.0, 0.0).duration)
