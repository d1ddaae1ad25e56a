"""What the process of an arm writes, whatever the device answers; without a process."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bt_manip import build_station
from bt_manip.robots import ArmDevice, DeviceState
from bt_manip.robots.connection_worker import ArmWorker, Field, SharedReadings, state_problem
from bt_manip.trajectories import sample_times, time_parameterize_segment

STEP = 1e-3
BEGUN, FIRST = 5.0, 30  # [s] of the arm's clock when it is connected, and a motion's setpoint
TOLERANCE = 1.01


class Device(ArmDevice):
    """An arm that follows at once, in simulated time; a fault occurs once at a call of a motion."""

    def __init__(
        self, q, fault=lambda device, state: state, at=-1, write_fault=None, extrapolated=0
    ):
        self.q, self.time, self.calls = q.copy(), BEGUN, 0
        self.fault, self.at, self.write_fault = fault, at, write_fault
        self.extrapolated_cycles = extrapolated
        self.written, self.times, self.finished, self.moving = [], [], 0, False
        self.reads_after_fault = 0

    def connect(self):
        pass

    def close(self):
        pass

    def recover(self):
        pass

    def read(self):
        self.time += self.period
        z = np.zeros(len(self.q))
        state = DeviceState(self.q.copy(), z, z, z, time=self.time)
        self.calls += self.moving
        self.reads_after_fault += self.moving and self.calls > self.at
        if self.fault is not None and self.moving and self.calls == self.at:
            return self.fault(self, state)
        return state

    def start(self):
        self.moving = True

    def write(self, q):
        if self.write_fault is not None and self.calls == self.at:
            raise self.write_fault
        self.q = np.array(q)
        self.written.append(self.q)
        self.times.append(self.time)

    def finish(self):
        self.moving, self.finished = False, self.finished + 1


class Parent:
    """The end of the pipe: sends one motion, and ends when the arm rests after it."""

    def __init__(self, device, setpoints):
        self.device, self.messages, self.answers = device, [("setpoints", FIRST, setpoints)], []

    def poll(self):
        if self.device.finished or self.device.calls > 5000:
            raise EOFError
        return bool(self.messages)

    def recv(self):
        return self.messages.pop()

    def send(self, answer):
        self.answers.append(answer)


@pytest.fixture(scope="module")
def model():
    return build_station().arm.model


@pytest.fixture(scope="module")
def motion(model):
    """Setpoints of a motion of half a second, as long as what is sent ahead to an arm."""
    goal = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    planned = time_parameterize_segment(goal - 0.12, goal + 0.12, model)
    return planned.sample(sample_times(planned.duration, STEP))[0]


def run(device, motion, limits):
    """Let a device execute a motion; return the shared readings."""
    shared = SharedReadings(bytearray(SharedReadings.size(len(limits.lower))), len(limits.lower))
    worker = ArmWorker(device, Parent(device, motion), limits)
    worker.run(shared)
    return shared


def bounded_run(device, motion, limits):
    """Let a device execute a motion, or refuse it; return the readings and the parent."""
    shared = SharedReadings(bytearray(SharedReadings.size(len(limits.lower))), len(limits.lower))
    parent = Parent(device, motion)
    poll = parent.poll

    def poll_once_more():
        if parent.answers and parent.answers[0][0]:
            raise EOFError
        return poll()

    parent.poll = poll_once_more
    ArmWorker(device, parent, limits).run(shared)
    return shared, parent


def check_written(device, limits):
    """Check that what was written is inside the limits, and that its end was asked for once."""
    q = np.array(device.written)
    v = np.diff(q, axis=0) / STEP
    assert (np.abs(v) <= TOLERANCE * limits.velocity + 1e-3).all()
    assert (np.abs(np.diff(v, axis=0)) / STEP <= TOLERANCE * limits.acceleration + 1e-2).all()
    assert device.finished == 1
    assert device.reads_after_fault * STEP < 1.0


def jump(seconds):
    def fault(device, state):
        device.time += seconds
        return state._replace(time=device.time)

    return fault


def sends(**fields):
    return lambda device, state: state._replace(**fields)


def raises(error):
    def fault(device, state):
        raise error

    return fault


SEVERE = {
    "a jump of the clock": jump(0.35),
    "a long jump of the clock": jump(100.0),
    "a huge time": lambda device, state: state._replace(time=1e300),
    "a clock that runs backwards": jump(-5.0),
    "a time of NaN": sends(time=math.nan),
    "a position of NaN": sends(q=np.full(7, np.nan)),
    "a joint too few": sends(q=np.zeros(6)),
    "a text for positions": sends(q=["a"] * 7),
    "velocities that are infinite": sends(v=np.full(7, np.inf)),
    "no reading": lambda device, state: None,
    "an error of the driver": raises(RuntimeError("read failed")),
    "an exit of the driver": raises(SystemExit(0)),
}


@pytest.mark.parametrize("fault", SEVERE.values(), ids=SEVERE)
def test_a_fault_in_a_motion_stops_it_inside_the_limits_with_a_reason(model, motion, fault):
    device = Device(motion[0], fault, at=200)
    shared = run(device, motion, model.limits)
    check_written(device, model.limits)
    assert shared.problem
    assert np.allclose(device.written[-1], motion[-1])  # on its path, to the end it was sent


def test_an_arm_that_cannot_be_written_to_is_ended_at_once(model, motion):
    device = Device(motion[0], at=200, write_fault=OSError("cable"))
    shared = run(device, motion, model.limits)
    check_written(device, model.limits)
    assert "could not be written: OSError: cable" in shared.problem
    assert device.reads_after_fault == 0


def test_a_clock_that_stands_still_stops_the_motion(model, motion):
    device = Device(motion[0])
    read = device.read

    def stopped():
        state = read()
        return state._replace(time=5.2) if device.calls > 200 else state

    device.read = stopped
    assert "the robot's clock" in run(device, motion, model.limits).problem
    check_written(device, model.limits)


@pytest.mark.parametrize(("lost", "extrapolated"), [(3, 0), (20, 0), (3, 20), (20, 20)])
def test_lost_cycles_are_passed_over_only_where_the_arm_extrapolates(
    model, motion, lost, extrapolated
):
    device = Device(motion[0], jump(lost * STEP), at=200, extrapolated=extrapolated)
    shared = run(device, motion, model.limits)
    assert not shared.problem
    assert shared.header[Field.LOST] == lost
    skipped = lost if lost <= extrapolated else 0
    step = np.abs(np.diff(np.array(device.written), axis=0)).max(axis=0)
    assert (step <= TOLERANCE * (1 + skipped) * model.limits.velocity * STEP).all()
    assert np.allclose(device.written[-1], motion[-1])
    if not skipped:
        check_written(device, model.limits)


@pytest.mark.parametrize("period", [5e-4, 1e-3, 2e-3, 2.5e-3, 4e-3, 1e-2])
def test_an_arm_of_any_period_gets_the_motion_in_its_own_time(model, motion, period):
    device = Device(motion[0])
    device.period = period
    shared = run(device, motion, model.limits)
    assert not shared.problem
    q, setpoint = np.array(device.written), (np.array(device.times) - BEGUN) / STEP - FIRST
    planned = [np.interp(setpoint, np.arange(len(motion)), joint) for joint in motion.T]
    np.testing.assert_allclose(q, np.transpose(planned), atol=1e-5)
    v = np.diff(q, axis=0) / period
    assert (np.abs(v) <= TOLERANCE * model.limits.velocity + 1e-3).all()
    assert (np.abs(np.diff(v, axis=0)) / period <= 1.05 * model.limits.acceleration).all()
    assert np.allclose(q[-1], motion[-1])


class Held(Device):
    """An arm that measures something else than what it holds, and that knows no torques."""

    def __init__(self, held, measured):
        super().__init__(held)
        self.measured = measured - held

    def read(self):
        state = super().read()
        return state._replace(
            q=self.q + self.measured, q_held=self.q.copy(), tau=None, tau_external=None
        )


@pytest.mark.parametrize("off", [0.0, 1e-3, 4.9e-3])
def test_a_motion_starts_smoothly_from_what_the_controller_holds(model, motion, off):
    device = Held(motion[0] + off, motion[0] + off)
    shared = run(device, motion, model.limits)
    assert not shared.problem
    check_written(device, model.limits)
    assert np.allclose(device.written[0], motion[0] + off)
    assert np.allclose(device.written[-1], motion[-1], atol=off)
    moved = np.abs(np.diff(np.array(device.written), axis=0))[:20].max()
    assert moved < 1e-4  # no jump to the first setpoint


def test_a_motion_that_begins_elsewhere_than_the_controller_holds_is_refused(model, motion):
    device = Held(motion[0] + 6e-3, motion[0])
    _, parent = bounded_run(device, motion, model.limits)
    assert not device.written
    assert parent.answers == [("moved", "joint 1 by 0.006 rad")]


@pytest.mark.parametrize(("error", "moves"), [(0.0, False), (0.05, True)])
def test_a_sagging_arm_starts_where_it_says_that_it_sags(model, motion, error, moves):
    device = Held(motion[0], motion[0] + np.array([0, 0.06, 0, 0, 0, 0, 0]))
    device.steady_state_error = error
    shared, parent = bounded_run(device, motion, model.limits)
    assert not shared.problem
    assert bool(device.written) is moves
    assert parent.answers == [("", "") if moves else ("moved", "joint 2 by 0.060 rad")]


def test_torques_that_are_unknown_are_a_valid_reading_and_no_zeros(model, motion):
    device = Held(motion[0], motion[0])
    assert state_problem(device.read(), 7) == ""
    shared = run(device, motion, model.limits)
    reading = shared.read(int(shared.header[Field.SETPOINT]))
    assert np.isnan(reading.tau).all() and np.isnan(reading.tau_external).all()
    assert np.isfinite(reading.q).all()


@given(
    fault=st.one_of(
        st.floats(0.001, 10.0).map(jump),
        st.floats(-10.0, 0.0).map(jump),
        st.sampled_from(list(SEVERE.values())),
    ),
    at=st.integers(1, 600),
)
@settings(max_examples=300, deadline=None)
def test_no_fault_at_any_time_writes_beyond_the_limits(model, motion, fault, at):
    device = Device(motion[0], fault, at)
    run(device, motion, model.limits)
    check_written(device, model.limits)
