"""The shortest time that a path can be driven in, computed by TOPP-RA (the package toppra).

H. Pham, Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability
Analysis", IEEE T-RO 34 (2018). It knows limits of velocity, acceleration and torque, and none of
jerk: nothing that keeps these can be faster, and what keeps a limit of jerk too is slower. Its
torques are linear in the square of the path's speed; damping, which is linear in the speed itself,
enters as what it takes at the speed found before, again and again.
"""

import logging

import numpy as np

from bt_manip.robots import RobotModel
from bt_manip.trajectories import PathTrajectory, SequenceTrajectory, Trajectory
from bt_manip.trajectories.paths import Path

GRID = 400  # intervals
ROUNDS = 40  # of the speed that damping is taken at
RELAXED = 0.5  # of each round's change of it
SETTLED = 2e-3  # of the greatest speed, below which a change is none


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

    speed = np.zeros(GRID + 1)  # that damping is taken at

    class Torques(constraint.JointTorqueConstraint):
        def compute_constraint_params(self, geometry, places, *rest):
            found = list(super().compute_constraint_params(geometry, places, *rest))
            found[2] = found[2] + model.damping * geometry(places, 1) * speed[:, np.newaxis]
            return tuple(found)

    def both(limit):
        return np.column_stack([-limit, limit])

    limits, geometry = model.limits, Geometry()
    places = np.linspace(0.0, 1.0, GRID + 1)
    possible, duration = speed, np.nan
    for _ in range(ROUNDS if model.damping.any() else 1):
        constraints = [
            constraint.JointVelocityConstraint(both(limits.velocity)),
            constraint.JointAccelerationConstraint(both(limits.acceleration)),
            Torques(
                model.rnea,
                both(limits.effort),
                model.friction,
                discretization_scheme=constraint.DiscretizationType.Collocation,
            ),
        ]
        solver = algorithm.TOPPRA(
            constraints, geometry, gridpoints=places, parametrizer="ParametrizeConstAccel"
        )
        _, found, _ = solver.compute_parameterization(0.0, 0.0)
        if found is None:  # the damping of a speed that nothing can keep
            speed = 0.5 * (speed + possible)
            continue
        duration = float((2.0 * np.diff(places) / (found[1:] + found[:-1])).sum())
        possible, change = speed, RELAXED * (found - speed)
        if np.abs(change).max() <= SETTLED * found.max():
            break
        speed = speed + change
    return duration
