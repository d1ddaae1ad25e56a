"""Arms whose reference moves alone, checked at every control step."""

import numpy as np
import pytest

from bt_manip.arm import Arm
from bt_manip.robots import Robot, RobotDescription, compile_alone

DT = 1e-3
EPS = 1e-6  # relative


class Watch:
    """Advances an arm and checks every step against its limits."""

    def __init__(self, arm: Arm):
        self.arm = arm
        self.rows = [self.now()]

    def now(self):
        return self.arm.q.copy(), self.arm.v.copy(), self.arm.a.copy()

    def run(self, steps: int = 10**6) -> None:
        while self.arm.moving and steps > 0:
            self.arm.advance(DT)
            self.rows.append(self.now())
            steps -= 1

    def check(self) -> None:
        limits = self.arm.model.limits
        q, v, a = (np.array(column) for column in zip(*self.rows, strict=True))
        assert limits.contain(q.min(axis=0), 1e-9) and limits.contain(q.max(axis=0), 1e-9)
        assert (np.abs(v) <= limits.velocity * (1 + EPS)).all()
        assert (np.abs(a) <= limits.acceleration * (1 + EPS)).all()
        assert (np.abs(np.diff(a, axis=0)) / DT <= limits.jerk * (1 + EPS)).all()
        # No jumps: the position changes by the mean velocity, the velocity by the mean
        # acceleration, except for a jerk that changes within a step.
        off_v = np.diff(q, axis=0) / DT - 0.5 * (v[1:] + v[:-1])
        off_a = np.diff(v, axis=0) / DT - 0.5 * (a[1:] + a[:-1])
        assert (np.abs(off_v) <= limits.jerk * DT**2 / 3).all()
        assert (np.abs(off_a) <= limits.jerk * DT / 2).all()

    def worst_effort(self) -> float:
        model = self.arm.model
        return max((np.abs(model.effort(*row)) / model.limits.effort).max() for row in self.rows)


@pytest.fixture
def watch(arm: Arm) -> Watch:
    return Watch(arm)


def arm_of(description: RobotDescription) -> Arm:
    """Return the arm of a robot that is compiled alone."""
    robot = Robot(description)
    compile_alone(robot)
    return Arm(robot)
