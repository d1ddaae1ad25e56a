"""What the process of an arm writes, whatever the device answers; without a process."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly, CubicSpline

from bt_manip.robots import ArmDevice, DeviceState
from bt_manip.robots.connection_worker import ArmWorker, Field, SharedReadings, state_problem
from bt_manip.trajectories import sample_times, time_parameterize_segment

pytestmark = pytest.mark.filterwarnings("error")  # such as of a division by zero

STEP = 1e-3
BEGUN, FIRST = 5.0, 30  # [s] of the arm's clock when it is connected, and a motion's setpoint
TOLERANCE = 1.01


class Device(ArmDevice):
    """An arm that follows at once, in simulated time, and misbehaves in a motion.

    `faults` by the number of a reading of the motion are functions of the device and its state that
    return or raise another one; `raised` is, by the name of a method, the reading from which on it
    raises, and what. `written` are the references, `passed` the times from the one before, as far
    as the arm extrapolates, and `times` when each was written; `finished` is how often the end of a
    motion was asked for.
    """

    def __init__(self, q, faults=(), raised=(), *, extrapolated=0, period=STEP):
        self.q, self.time, self.last = q.copy(), BEGUN, BEGUN
        self.faults, self.raised = dict(faults), dict(raised)
        self.extrapolated_cycles, self.period = extrapolated, period
        self.written, self.passed, self.finished, self.moving = [], [], 0, False
        self.times, self.readings = [], 0
        self.first = min([*self.faults, *(at for at, _ in self.raised.values())], default=math.inf)

    @property
    def after_fault(self):
        return max(0, self.readings - self.first)

    def raise_in(self, method):
        at, error = self.raised.get(method, (math.inf, None))
        if self.readings >= at:
            raise error

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
        self.readings += self.moving
        fault = self.faults.get(self.readings) if self.moving else None
        return state if fault is None else fault(self, state)

    def start(self):
        self.raise_in("start")
        self.moving = True

    def write(self, q):
        self.raise_in("write")
        cycles, self.last = round((self.time - self.last) / self.period), self.time
        extrapolates = 0 < cycles <= 1 + self.extrapolated_cycles
        self.passed.append((cycles if extrapolates else 1) * self.period)
        self.q = np.array(q)
        self.written.append(self.q)
        self.times.append(self.time)

    def finish(self):
        self.moving, self.finished = False, self.finished + 1
        self.raise_in("finish")


class Parent:
    """The end of the pipe: sends one motion, and ends when the arm rests after it or refuses it.

    `later` are more messages, by the number of the poll that finds them.
    """

    def __init__(self, device, setpoints, later=()):
        self.device, self.messages, self.answers = device, [("setpoints", FIRST, setpoints)], []
        self.polls, self.ends_when_refused, self.later = 0, True, dict(later)

    def poll(self):
        self.polls += 1
        if self.polls in self.later:
            self.messages.append(self.later[self.polls])
        refused = self.ends_when_refused and self.answers and self.answers[0][0]
        if self.device.finished or refused or self.polls > 5000:
            raise EOFError
        return bool(self.messages)

    def recv(self):
        return self.messages.pop()

    def send(self, answer):
        self.answers.append(answer)


@pytest.fixture(scope="module")
def model(compiled_robot):
    return compiled_robot.make_model()


@pytest.fixture(scope="module")
def motion(model):
    """Setpoints of a motion of half a second, as long as what is sent ahead to an arm."""
    goal = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    planned = time_parameterize_segment(goal - 0.12, goal + 0.12, model)
    return planned.sample(sample_times(planned.duration, STEP))[0]


def work(device, parent, limits):
    """Let a device do what a parent asks for; return the shared readings."""
    shared = SharedReadings(bytearray(SharedReadings.size(len(limits.lower))), len(limits.lower))
    ArmWorker(device, parent, limits).run(shared)
    return shared


def run(device, motion, limits):
    return work(device, Parent(device, motion), limits)


def check_written(device, limits):
    """Check that what was written is inside the limits, and that its end was asked for once."""
    q, passed = np.array(device.written), np.array(device.passed)[:, np.newaxis]
    v = np.diff(q, axis=0) / passed[1:]
    a = np.diff(v, axis=0) / (0.5 * (passed[1:-1] + passed[2:]))
    assert (np.abs(v) <= TOLERANCE * limits.velocity + 1e-3).all()
    assert (np.abs(a) <= TOLERANCE * limits.acceleration + 1e-2).all()
    assert device.finished == 1
    assert device.after_fault * device.period < 1.0


def jump(seconds):
    def fault(device, state):
        device.time += seconds
        return state._replace(time=device.time)

    return fault


def stands(count):
    """Let the clock stand still for a number of readings more."""

    def fault(device, state):
        device.faults.update(
            (device.readings + i, sends(time=state.time)) for i in range(1, count + 1)
        )
        return state

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
    "a jump of the clock by 21 ms": jump(0.021),
    "a clock that stands still for 22 ms": stands(22),
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
    device = Device(motion[0], {200: fault})
    shared = run(device, motion, model.limits)
    check_written(device, model.limits)
    assert shared.problem
    assert np.allclose(device.written[-1], motion[-1])  # on its path, to the end it was sent


def test_an_arm_that_cannot_be_written_to_is_ended_at_once(model, motion):
    device = Device(motion[0], raised={"write": (200, OSError("cable"))})
    shared = run(device, motion, model.limits)
    check_written(device, model.limits)
    assert "could not be written: OSError: cable" in shared.problem
    assert device.after_fault == 0


def test_a_clock_that_stands_still_stops_the_motion(model, motion):
    device = Device(motion[0], {200: stands(1000)})
    assert "the robot's clock" in run(device, motion, model.limits).problem
    check_written(device, model.limits)


@pytest.mark.parametrize(("lost", "extrapolated"), [(3, 0), (20, 3), (20, 20)])
def test_lost_cycles_are_passed_over_only_where_the_arm_extrapolates(
    model, motion, lost, extrapolated
):
    device = Device(motion[0], {200: jump(lost * STEP)}, extrapolated=extrapolated)
    shared = run(device, motion, model.limits)
    assert not shared.problem
    assert shared.header[Field.LOST] == lost
    skipped = lost if lost <= extrapolated else 0
    assert max(device.passed) == pytest.approx((1 + skipped) * STEP)
    assert np.allclose(device.written[-1], motion[-1])
    check_written(device, model.limits)


def test_readings_that_repeat_a_time_are_no_lost_cycles_afterwards(model, motion):
    device = Device(motion[0], {200: stands(19), 230: jump(5 * STEP), 260: stands(2)})
    shared = run(device, motion, model.limits)
    assert not shared.problem and shared.header[Field.LOST] == 5
    check_written(device, model.limits)


@pytest.mark.parametrize("period", [5e-4, 2.5e-3, 1e-2])
def test_an_arm_of_any_period_gets_the_motion_in_its_own_time(model, motion, period):
    device = Device(motion[0])
    device.period = period
    shared = run(device, motion, model.limits)
    assert not shared.problem
    q, setpoint = np.array(device.written), (np.array(device.times) - BEGUN) / STEP - FIRST
    ends = CubicSpline(np.arange(len(motion)), motion)(np.clip(setpoint, 0, len(motion) - 1))
    np.testing.assert_allclose(q, ends, atol=5e-7)
    assert device.times[-1] - BEGUN == pytest.approx((FIRST + len(motion)) * STEP + 0.1, abs=0.011)
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


@pytest.mark.parametrize("off", [0.0, 4.9e-3])
def test_a_motion_starts_smoothly_from_what_the_controller_holds(model, motion, off):
    longer = np.concatenate([motion, np.repeat(motion[-1:], 800, axis=0)])
    held = motion[0] + off * np.array([1.0, -1.0, 0.5, 0.0, 0.2, -0.3, 0.1])
    device = Held(held, held)
    shared = run(device, longer, model.limits)
    assert not shared.problem
    check_written(device, model.limits)
    s = np.minimum(np.arange(len(device.written)), 1000)[:, np.newaxis] * STEP  # in a second
    left = BPoly.from_derivatives([0.0, 1.0], [[1.0, 0.0, 0.0], [0.0] * 3])(s)  # minimum jerk
    planned = longer[np.clip(np.arange(len(s)) - FIRST + 1, 0, len(longer) - 1)]
    np.testing.assert_allclose(device.written, planned + left * (held - motion[0]), atol=1e-12)


@pytest.mark.parametrize(
    ("sent", "first", "answer"),
    [
        (130, 131, ("", "")),
        (130, 130, ("late", "")),
        (20, 25, ("", "")),  # in place of a motion that has not begun
        (20, FIRST + 2, ("", "")),
        (440, 470, ("", "")),  # from rest at the end of the first one
        (20, FIRST + 2, ("limits", "velocity of joint 1 where it joins the present one")),
        (130, 150, ("limits", "velocity of joint 1 where it joins the present one")),
    ],
)
def test_setpoints_replace_those_of_a_motion_from_their_number_on(
    model, motion, sent, first, answer
):
    motion = 0.5 * (motion + motion[0])  # leaves half of each limit
    s = np.linspace(0.0, 1.0, 400)[:, np.newaxis]
    rise = 0.01 * s**3 * (10.0 - 15.0 * s + 6.0 * s * s) * np.arange(1.0, 8.0)
    begin = max(first - FIRST, 0)
    rest = motion[np.minimum(np.arange(begin, begin + 600), len(motion) - 1)]
    new = rest + np.pad(rise, ((0, 200), (0, 0)), mode="edge") + 0.01 * (answer[0] == "limits")
    device = Device(motion[0])
    parent = Parent(device, motion, {sent: ("setpoints", first, new)})
    shared = work(device, parent, model.limits)
    assert parent.answers == [("", ""), answer] and not shared.problem
    expected = np.concatenate([np.repeat(motion[:1], FIRST, axis=0), motion])
    if not any(answer):
        held = np.pad(expected, ((0, 900), (0, 0)), mode="edge")
        expected = np.concatenate([held[:first], new])
    ends = np.minimum(np.arange(1, len(device.written) + 1), len(expected) - 1)
    assert len(device.written) == len(expected) + 99
    np.testing.assert_allclose(device.written, expected[ends], atol=1e-12)


@pytest.mark.parametrize(("pause", "steps"), [(0.3, 300), (5.0, 1000), (-0.2, 1), (0.0004, 1)])
def test_the_time_that_passes_at_rest_counts_up_to_a_second(model, motion, pause, steps):
    device = Device(motion[0])
    parent, read = Parent(device, motion), device.read
    parent.messages = []

    def read_after_a_pause():
        device.time += pause - STEP if parent.polls == 10 else 0.0
        device.finished = parent.polls >= 20
        return read()

    device.read = read_after_a_pause
    assert work(device, parent, model.limits).header[Field.SETPOINT] == 20 + steps


def test_an_arm_that_could_not_start_moves_again_once_it_has_recovered(model, motion):
    device = Device(motion[0], raised={"start": (0, OSError("busy"))})
    device.recover = device.raised.clear
    later = {50: ("recover",), 100: ("setpoints", FIRST + 200, motion)}
    parent = Parent(device, motion, later)
    parent.ends_when_refused = False
    work(device, parent, model.limits)
    assert [problem for problem, _ in parent.answers] == ["problem", ""]
    assert device.finished == 1
    np.testing.assert_allclose(device.written[-1], motion[-1], atol=1e-6)


@pytest.mark.parametrize(
    ("held", "sags", "error", "moved"),
    [
        (5.1e-3, 0.0, 0.0, "joint 1 by 0.005 rad"),  # the controller holds something else
        (0.0, -0.021, 0.0, "joint 2 by 0.021 rad"),
        (0.0, -0.019, 0.0, ""),
        (0.0, 0.069, 0.05, ""),  # it says that it sags
    ],
)
def test_a_motion_begins_where_the_arm_is_or_is_refused(model, motion, held, sags, error, moved):
    sag = np.array([0, sags, 0, 0, 0, 0, 0])
    device = Held(motion[0] + held * (np.arange(7) == 0), motion[0] + sag)
    device.steady_state_error = error
    parent = Parent(device, motion)
    shared = work(device, parent, model.limits)
    assert not shared.problem
    assert bool(device.written) is not bool(moved)
    assert parent.answers == [("moved", moved) if moved else ("", "")]


def test_torques_that_are_unknown_are_a_valid_reading_and_no_zeros(model, motion):
    device = Held(motion[0], motion[0])
    assert state_problem(device.read(), 7) == ""
    shared = run(device, motion, model.limits)
    reading = shared.read(int(shared.header[Field.SETPOINT]))
    assert np.isnan(reading.tau).all() and np.isnan(reading.tau_external).all()
    assert np.isfinite(reading.q).all()


TIMES = st.one_of(st.floats(-10.0, 10.0), st.integers(1, 10_000).map(lambda n: n * STEP))
FAULTS = st.one_of(
    TIMES.map(jump),
    st.integers(1, 100).map(stands),
    st.sampled_from(list(SEVERE.values())),
    st.tuples(st.sampled_from(["q", "v", "tau", "tau_external", "q_held"]), st.integers(0, 6)).map(
        lambda place: sends(**{place[0]: np.where(np.arange(7) == place[1], math.nan, 0.0)})
    ),
    st.just(sends(problem="a reflex")),
)
ERRORS = st.sampled_from([OSError("cable"), RuntimeError("driver"), SystemExit(1)])


@pytest.mark.parametrize("count", [20, pytest.param(1000, marks=pytest.mark.soak)])
def test_no_faults_at_any_time_write_beyond_the_limits(model, motion, count):
    @settings(max_examples=count, deadline=None)
    @given(
        faults=st.dictionaries(st.integers(1, 600), FAULTS, min_size=1, max_size=3),
        raised=st.dictionaries(
            st.sampled_from(["write", "finish"]), st.tuples(st.integers(1, 600), ERRORS), max_size=1
        ),
        extrapolated=st.sampled_from([0, 3, 20]),
        period=st.sampled_from([STEP, 2 * STEP, 4 * STEP]),
    )
    def check(faults, raised, extrapolated, period):
        device = Device(motion[0], faults, raised, extrapolated=extrapolated, period=period)
        shared = run(device, motion, model.limits)
        check_written(device, model.limits)
        assert shared.problem or np.allclose(device.written[-1], motion[-1])

    check()


def test_every_number_of_a_reading_arrives_at_its_place():
    q, v, tau, external, q_ref = np.arange(10.0).reshape(5, 2)
    shared = SharedReadings(bytearray(SharedReadings.size(2)), 2)
    shared.write(0, DeviceState(q, v, tau, external), q_ref)
    assert np.array_equal(shared.read(0), [q, v, tau, external, q_ref])
