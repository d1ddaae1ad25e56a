"""Changes of a motion that take effect later, as for a real arm: what is sent is what happens."""

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.robots import DeviceError, LateError


class Table:
    """The setpoints of a connection, spliced as in the process that speaks to the arm."""

    def __init__(self, arm):
        self.arm, self.setpoint, self.lag, self.problem, self.streaming = arm, 0, 0, "", True
        self.setpoints = np.tile(arm.q, (4, 1))  # from setpoint -3
        self.sent = 0
        self.refuse, self.problem_of_sending = 0, ""
        self.shortest = np.inf
        arm.connection, arm.follower.send = self, self.send

    def send(self, latency, setpoints):
        if self.problem_of_sending:
            raise DeviceError(self.problem_of_sending)
        if self.refuse:
            self.refuse -= 1
            raise LateError
        first = self.setpoint + latency + 3
        self.extend(first)
        problem = self.arm.model.limits.setpoints_problem(
            self.setpoints[first - 3 : first], setpoints
        )
        assert problem == ""
        self.setpoints = np.concatenate([self.setpoints[:first], setpoints])
        self.sent += 1
        self.shortest = min(self.shortest, latency)

    def extend(self, length):
        missing = max(0, length - len(self.setpoints))
        self.setpoints = np.concatenate(
            [self.setpoints, np.repeat(self.setpoints[-1:], missing, axis=0)]
        )

    def advance(self, steps):
        """Advance, with a refresh every 100 setpoints; check the reference."""
        for _ in range(steps):
            self.setpoint += 1
            self.arm.advance(1e-3)
            if self.setpoint % 100 == 0 and self.arm.moving:
                remaining = self.arm.remaining - 1e-9  # of the first, 500 setpoints are sent
                assert self.arm.follower.send_on(25, self.arm.model) == (remaining > 0.525)
            self.extend(self.setpoint + 4)
            np.testing.assert_allclose(self.setpoints[self.setpoint + 3], self.arm.q, atol=1e-12)


@pytest.fixture
def table(arm):
    return Table(arm)


@pytest.fixture
def slow_from(arm, table):
    """Start a slow motion of the first joint, and give where it begins."""
    start = arm.q_ref
    arm.speed_scale = 0.2
    arm.move_to_configuration(start + np.eye(7)[0])
    return start


def random_change(arm, rng):
    limits = arm.model.limits
    middle, half = 0.5 * (limits.lower + limits.upper), 0.5 * (limits.upper - limits.lower)
    goal = middle + 0.6 * half * rng.uniform(-1.0, 1.0, arm.model.nq)
    change = rng.integers(7)
    if change == 0:
        arm.stop()
    elif change == 1:
        arm.pause()
    elif change == 2:
        arm.speed_scale = rng.uniform(0.1, 1.0)
    elif change == 3:
        arm.resume()
    elif change == 4:
        arm.blend_radius = 0.05
        arm.move_to_configuration(goal)
    elif change == 5:
        arm.servo(arm.q + 0.05 * rng.uniform(-1.0, 1.0, arm.model.nq), np.zeros(arm.model.nq), 0.1)
    else:
        arm.move_to_configuration(goal, speed=rng.uniform(0.3, 1.0))


SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(1, 20))]


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_sent_is_the_reference_and_inside_the_limits(arm, table, seed):
    rng = np.random.default_rng(seed)
    refused = 0
    for _ in range(15):
        try:
            random_change(arm, rng)
        except MotionError as error:  # such as efforts
            refused += error.reason not in ("effort", "limits")
        table.advance(int(rng.integers(5, 400)))
    arm.stop()
    table.advance(1500)
    assert not arm.moving and table.sent > 12 and not refused


def test_a_stop_takes_effect_soon_and_ends_on_the_path(arm, table):
    start = arm.q_ref
    goal = start + np.array([1.0, 0, 0, 0, 0, 0, 0])
    arm.move_to_configuration(goal)
    table.advance(300)
    arm.stop()
    assert table.shortest <= 15
    table.advance(1000)
    assert not arm.busy and start[0] < arm.q[0] < goal[0]
    np.testing.assert_allclose(arm.q[1:], start[1:], atol=1e-9)


def test_the_reference_ahead_of_a_motion_that_begins_later_is_what_it_becomes(arm, table):
    assert np.array_equal(arm.follower.ahead(np.zeros(2)), [arm.q, arm.q])
    arm.move_to_configuration(arm.q_ref + np.linspace(-0.3, 0.2, 7))
    table.advance(30)
    predicted = arm.follower.ahead(np.array([0.0, 0.0204, 0.0496, 0.1503, 0.4, 9.0]))
    remaining, states, rows = arm.remaining, [], [(arm.q_ref, arm.v.copy(), arm.a.copy())]
    for arm.follower.latency in (12, 37, 500):
        states.append(arm.follower.state)
    arm.follower.latency = 0
    for _ in range(500):
        remaining -= 1e-3 * arm.moving
        table.advance(1)
        rows.append((arm.q_ref, arm.v.copy(), arm.a.copy()))
    assert -2e-3 < remaining <= 0.0
    np.testing.assert_array_equal(predicted, [rows[k][0] for k in (0, 20, 50, 150, 400, 500)])
    for state, k, time in zip(states, (12, 37, 500), (0.0, 0.007, 0.0), strict=True):
        np.testing.assert_array_equal(state[:3], rows[k])
        assert state.time == pytest.approx(time) and (state.trajectory is None) == (k == 500)


def test_a_change_that_is_late_is_planned_again_with_twice_the_time(arm, table):
    table.refuse = 2
    arm.move_to_configuration(arm.q_ref + 0.3)
    assert table.sent == 1 and table.shortest == 4 * 60
    table.refuse = 10
    with pytest.raises(MotionError, match="too busy for the arm"):
        arm.move_to_configuration(arm.q_ref - 0.3)
    table.refuse = 0
    table.advance(1500)
    assert not arm.moving


def test_a_motion_ends_in_a_stop_planned_ahead_when_nothing_more_is_sent(table, slow_from):
    rest = table.setpoints[-1]
    assert 0.02 < rest[0] - slow_from[0] < 0.9
    assert np.abs(np.diff(table.setpoints[-2:], axis=0)).max() < 1e-6
    assert len(table.setpoints) < 1000  # setpoints of 1 ms


def test_there_are_no_compliant_stops_and_no_jumps_to_the_measured_joints(arm, table):
    arm.move_to_configuration(arm.q_ref + 0.3)
    table.advance(200)
    arm.stop("something", compliant=True)
    table.advance(1000)
    before = arm.q_ref
    arm.hold_at(before + 0.1)
    assert not arm.compliant and arm.fault == "something"
    np.testing.assert_array_equal(arm.q, before)


def test_a_speed_that_cannot_be_changed_in_time_stops_the_arm_on_its_path(arm, table, slow_from):
    table.advance(310)
    arm.follower.lagging, table.refuse = True, 5
    table.advance(1000)
    assert not arm.busy and 0.02 < arm.q[0] - slow_from[0] < 0.5
    assert "speed could not be changed" in arm.fault and "too busy" in arm.fault


def test_an_arm_that_takes_no_stop_is_given_up_and_stops_at_the_end_of_what_it_has(
    arm, table, slow_from
):
    table.advance(300)
    sent, table.problem_of_sending = table.setpoints, "a reflex"
    arm.follower.lagging = True
    for _ in range(25):
        arm.advance(1e-3)
    assert not arm.busy and arm.fault.count("a reflex") == 2
    assert "speed could not be changed" in arm.fault and "it could not be stopped" in arm.fault
    with pytest.raises(MotionError, match="has not come to rest yet"):
        arm.move_to_configuration(slow_from)
    assert table.setpoints is sent
    assert np.abs(np.diff(sent[-2:], axis=0)).max() < 1e-6
