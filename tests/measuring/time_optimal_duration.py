"""The time-optimal duration of a path, computed by TOPP-RA (the package toppra).

H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability
Analysis", IEEE T-RO 34 (2018). It keeps velocity, acceleration and torque limits, and no jerk
limits: no trajectory that keeps these limits is faster, and one that keeps jerk limits too is
slower. Its torques are linear in the squared path velocity. Damping is linear in the path velocity
itself, and is evaluated at that of the previous iteration.
"""

import logging

import numpy as np

from bt_manip.robots import RobotModel
from bt_manip.trajectories import Path, PathTrajectory, SequenceTrajectory, Trajectory

GRID = 400  # intervals
ITERATIONS = 40  # of the path velocity at which damping is evaluated
RELAXATION = 0.5  # of its change in each iteration
CONVERGED = 2e-3  # relative change of it that ends the iterations


def missing() -> str:
    """Return how to install toppra; empty where it is installed."""
    try:
        import toppra  # noqa: F401
    except ImportError as error:
        return f"{error}; 'pip install toppra' brings it"
    return ""


def time_optimal_duration(trajectory: Trajectory, model: RobotModel) -> float:
    """Return the time-optimal duration of a trajectory's path from rest to rest [s].

    All limits are used in full, effort limits included.
    """
    if isinstance(trajectory, SequenceTrajectory):
        return sum(time_optimal_duration(part, model) for part in trajectory.parts)
    assert isinstance(trajectory, PathTrajectory)
    return _path_duration(trajectory.path, model)


def _path_duration(path: Path, model: RobotModel) -> float:
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

    speed = np.zeros(GRID + 1)  # s_dot at which damping is evaluated

    class Torques(constraint.JointTorqueConstraint):
        def compute_constraint_params(self, geometry, places, *rest):
            found = list(super().compute_constraint_params(geometry, places, *rest))
            found[2] = found[2] + model.damping * geometry(places, 1) * speed[:, np.newaxis]
            return tuple(found)

    def symmetric(limit):
        return np.column_stack([-limit, limit])

    def velocity_range(place):
        q, slope = (rows[0, : path.nq] for rows in path.evaluate(np.array([place]))[:2])
        return symmetric(model.limits.velocity_at(q, slope))

    limits, geometry = model.limits, Geometry()
    places = np.linspace(0.0, 1.0, GRID + 1)
    possible, duration = speed, np.nan
    for _ in range(ITERATIONS if model.damping.any() else 1):
        constraints = [
            constraint.JointVelocityConstraintVarying(velocity_range)
            if limits.near is not None
            else constraint.JointVelocityConstraint(symmetric(limits.velocity)),
            constraint.JointAccelerationConstraint(symmetric(limits.acceleration)),
            Torques(
                model.rnea,
                symmetric(limits.effort),
                model.friction,
                discretization_scheme=constraint.DiscretizationType.Collocation,
            ),
        ]
        solver = algorithm.TOPPRA(
            constraints, geometry, gridpoints=places, parametrizer="ParametrizeConstAccel"
        )
        _, found, _ = solver.compute_parameterization(0.0, 0.0)
        if found is None:  # infeasible: the damping at that speed is too great
            speed = 0.5 * (speed + possible)
            continue
        duration = float((2.0 * np.diff(places) / (found[1:] + found[:-1])).sum())
        possible, change = speed, RELAXATION * (found - speed)
        if np.abs(change).max() <= CONVERGED * found.max():
            break
        speed = speed + change
    return duration
