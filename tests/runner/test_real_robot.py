"""The twin of a real robot counts late ticks, and knows how long the robot goes on by itself."""

from types import SimpleNamespace

import pytest

from bt_manip.arm import SENT_AHEAD
from bt_manip.runner.real_robot import LATE, MOST, REFRESH, SILENT, RealRobot


class Twin(RealRobot):
    """The twin of an arm that is at rest, without a connection."""

    def __init__(self):
        self.cell, self.late_ticks = SimpleNamespace(step=lambda steps, then: None), 0
        self.faults, self.sent = [], []
        follower = SimpleNamespace(send_on=lambda latency, model: self.sent.append(latency) or True)
        self.times = SimpleNamespace(time=2.0)
        self._arm = self.arm = SimpleNamespace(
            moving=False,
            model=None,
            follower=follower,
            give_up=self.faults.append,
            robot=SimpleNamespace(mj_data=self.times),
        )
        self._connection = self.connection = SimpleNamespace(
            setpoint=0, lag=0, send=lambda latency, setpoints: None
        )

    def _follow(self):
        pass

    def send(self, latency):
        self._send(latency, None)

    def send_on(self, setpoint):
        self.connection.setpoint = setpoint
        self._send_on()


@pytest.mark.parametrize(("more", "late"), [(0, 0), (LATE, 0), (LATE + 1, 1)])
def test_a_tick_is_late_that_takes_more_than_a_few_steps_longer(more, late):
    robot = Twin()
    robot.connection.wait = lambda steps: steps + more
    robot.step(50)
    assert robot.late_ticks == late


def test_steps_beyond_the_most_of_a_tick_are_made_by_the_reference_alone():
    robot, made, advanced = Twin(), [], []
    robot.cell.step = lambda steps, then: made.append(steps)
    robot.arm.advance = advanced.append
    robot.connection.wait = lambda steps: MOST + 40
    robot.step(50)
    assert made == [MOST] and advanced == [1e-3] * 40
    assert robot.connection.setpoint == 40 and robot.times.time == pytest.approx(2.04)


@pytest.mark.parametrize("latency", [10, 60])
def test_a_motion_goes_on_until_what_was_sent_ahead_ends(latency):
    robot = Twin()
    robot.send(latency)
    robot.send_on(REFRESH)
    assert robot.sent and not robot.faults
    robot.send_on(latency + SENT_AHEAD)
    assert robot.faults == [SILENT] and len(robot.sent) == 1
