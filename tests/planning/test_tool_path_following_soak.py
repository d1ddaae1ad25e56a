"""Many random tool paths: inside all limits, or refused with a reason."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.exceptions import MotionError
from bt_manip.planning import ArcTo, LineTo, TurnAbout, tool_paths
from bt_manip.trajectories import effort_use, limit_use

PATHS = 150


def random_steps(rng, at):
    """Draw two to four steps in front of the arm."""
    steps = []
    for _ in range(rng.integers(2, 5)):
        place = np.clip(at + rng.uniform(-0.2, 0.2, 3), [0.3, -0.4, 0.15], [0.6, 0.4, 0.6])
        tilt = pin.exp3(rng.uniform(-0.4, 0.4, 3))
        T = pin.SE3(spatial.pointing_down(place).rotation @ tilt, place)
        kind = rng.integers(4)
        if kind == 0:
            steps.append(ArcTo(0.5 * (at + place) + rng.uniform(0.02, 0.1, 3), T))
        elif kind == 1:
            angle = rng.uniform(-0.8, 0.8)
            steps.append(TurnAbout(at + rng.uniform(-0.1, 0.1, 3), rng.normal(size=3), angle))
        else:
            steps.append(LineTo(T))
        at = place
    return steps


@pytest.mark.soak
def test_random_paths_are_inside_all_limits_or_refused_with_how_far_they_go(arm):
    rng, followed = np.random.default_rng(11), 0
    for _ in range(PATHS):
        start = rng.uniform([0.35, -0.25, 0.25], [0.55, 0.25, 0.5])
        arm.reset(arm.ik.nearest(spatial.pointing_down(start), arm.model.home, margin=0.1).q)
        steps, blend = random_steps(rng, start), float(rng.choice([0.0, 0.01, 0.05]))
        paths = tool_paths(arm.model.pose(arm.q), steps, blend)
        try:
            arm.move_path(steps, blend=blend)
        except MotionError as error:
            assert error.reason == "line" and not arm.moving
            assert error.fraction is None or 0.0 <= error.fraction < 1.0
            continue
        followed += 1
        trajectory = arm.trajectory
        assert limit_use(trajectory, arm.model.limits).inside
        assert effort_use(trajectory, arm.model) <= 0.96
        q, v, _ = trajectory.sample(np.arange(0.0, trajectory.duration, 2e-3))
        rates = np.array([arm.model.jacobian(x) @ u for x, u in zip(q, v, strict=True)])
        limits = arm.model.limits.tool
        assert np.linalg.norm(rates[:, :3], axis=1).max() <= 1.001 * limits.velocity
        assert np.linalg.norm(rates[:, 3:], axis=1).max() <= 1.001 * limits.angular_velocity
        end = arm.model.pose(trajectory.end)
        assert np.abs(pin.log6(paths[-1].pose(1.0).actInv(end)).np).max() < 1e-5
    assert followed > 0.6 * PATHS
