"""Contract of backends: the arm and the gripper of one behave as bt-manip needs it.

Each check of an arm gets a station with a real robot, simulated by its vendor or not, which can
move its first joint by 0.5 rad, and leaves the arm at rest. Each check of a gripper gets the
connected device, with nothing between its fingers, and its maximum width [m].
"""

import time
from collections.abc import Callable

import numpy as np

from bt_manip.robots import DeviceError, GripperDevice, LateError
from bt_manip.runner import Station

STROKE = 0.5  # [rad] of the first joint
ARRIVED = 5e-3  # [rad]
STOP_TIME = 0.05  # [s] in which a stop begins
LONGEST = 20.0  # [s] of a motion
RECOVERY_TIME = 2.0  # [s] from a problem's recovery until the arm is ready
READ_TIME = 0.1  # [s] of wall time in which a gripper tells its state
WIDTH_ERROR = 5e-3  # [m]
SPEED, FORCE = 0.1, 20.0  # [m/s], [N] of commands to grippers


def stays_on_a_motion_to_its_end(station: Station) -> None:
    """Check that the arm follows a motion and rests at its end."""
    goal = _set_off(station)
    errors, arm = [0.0], station.arm
    _wait_for_rest(station, lambda: errors.append(float(np.abs(arm.robot.q - arm.q).max())))
    worst = max(errors)
    assert worst < 0.1, f"the arm was {worst:.3f} rad off its reference"
    _assert_at(station, goal)


def stops_on_its_path(station: Station) -> None:
    """Check that a stop begins within 50 ms of robot time and keeps the other joints still."""
    arm = station.arm
    start = arm.q_ref
    goal = _set_off(station)
    _begin_to_move(station)
    speed, asked = abs(arm.v[0]), station.cell.time
    arm.stop()
    _wait(station, lambda: abs(arm.v[0]) <= 0.98 * speed, 1.0, "the arm goes on")
    late = station.cell.time - asked - 0.02  # two ticks until it is seen
    assert late < STOP_TIME, f"the stop began {1e3 * late:.0f} ms after it was requested"
    _wait_for_rest(station)
    assert abs(arm.q[0] - goal[0]) > 0.02, "the arm went on to its goal"
    others = float(np.abs(arm.q - start)[1:].max())
    assert others < ARRIVED, f"another joint has moved by {others:.3f} rad"
    _assert_at(station, arm.q_ref)


def stops_by_itself_when_nothing_more_arrives(station: Station) -> None:
    """Check that the arm rests on its path when its parent is silent, and moves again later."""
    arm = station.arm
    arm.speed_scale = 0.2
    _set_off(station)
    _begin_to_move(station)
    time.sleep(2.5)  # silent
    _wait_for_rest(station)
    arm.speed_scale = 1.0
    assert "no motion arrived in time" in arm.fault, f"it says '{arm.fault}'"
    stays_on_a_motion_to_its_end(station)


def refuses_a_change_that_comes_too_late(station: Station) -> None:
    """Check that the motion goes on when a change of it arrives after its setpoint."""
    arm = station.arm
    goal = _set_off(station)
    _begin_to_move(station)
    send = arm.follower.send
    assert send is not None
    try:
        send(-20, np.tile(arm.q, (10, 1)))
    except LateError:
        _wait_for_rest(station)
        _assert_at(station, goal)
        return
    raise AssertionError("a change that came too late was accepted")


def refuses_what_exceeds_a_limit(station: Station) -> None:
    """Check that a jump is refused with its reason, and nothing moves."""
    arm = station.arm
    before = arm.q_ref
    setpoints = np.concatenate([np.tile(before, (5, 1)), np.tile(before + 0.05, (5, 1))])
    send = arm.follower.send
    assert send is not None
    try:
        send(50, setpoints)
    except DeviceError as error:
        assert "limit" in str(error), f"it says '{error}'"
        _assert_at(station, before)
        return
    raise AssertionError("a jump of the reference was accepted")


def recovers_from_a_problem(station: Station, provoke: Callable[[], object]) -> None:
    """Check that a problem in a motion is named, and that the arm moves again after its recovery.

    Args:
        station: The station.
        provoke: Brings about a recoverable problem of the moving arm, such as a reflex.
    """
    arm = station.arm
    _set_off(station)
    _begin_to_move(station)
    provoke()
    _wait_for_rest(station)
    assert arm.problem, "the arm names no problem"
    assert arm.problem in arm.fault, f"the problem is '{arm.problem}', the fault '{arm.fault}'"
    arm.recover()
    _wait(station, lambda: not arm.problem, RECOVERY_TIME, f"still: {arm.problem}")
    stays_on_a_motion_to_its_end(station)


DEVICE_CONTRACT = (
    stays_on_a_motion_to_its_end,
    stops_on_its_path,
    stops_by_itself_when_nothing_more_arrives,
    refuses_a_change_that_comes_too_late,
    refuses_what_exceeds_a_limit,
)


def moves_to_widths(gripper: GripperDevice, open_width: float) -> None:
    """Check that the gripper moves to widths, tells that it got there, and holds nothing there."""
    for width in (open_width, 0.5 * open_width, 0.5 * open_width, open_width):
        assert gripper.move(width, SPEED) is True, f"it says it did not get to {width:g} m"
        _assert_width(gripper, width)


def grips_nothing_where_nothing_is(gripper: GripperDevice, open_width: float) -> None:
    """Check that the gripper closes on nothing and tells so, and opens again."""
    gripper.move(open_width, SPEED)
    assert gripper.grasp(0.0, SPEED, FORCE) is False, "it says that it grips something"
    state = gripper.read()
    assert not state.is_grasped and state.width < open_width - WIDTH_ERROR, f"it is {state}"
    moves_to_widths(gripper, open_width)


def refuses_a_width_that_it_cannot_reach(gripper: GripperDevice, open_width: float) -> None:
    """Check that the gripper does not claim to reach a width beyond its range."""
    try:
        reached = gripper.move(2.0 * open_width, SPEED)
    except DeviceError:
        reached = False
    assert reached is False, f"it says that it got to {2.0 * open_width:g} m"
    moves_to_widths(gripper, open_width)


def tells_its_state_at_once(gripper: GripperDevice, open_width: float) -> None:
    """Check that a reading takes at most 0.1 s, is finite and has no problem."""
    begun = time.monotonic()
    state = gripper.read()
    took = time.monotonic() - begun
    assert took < READ_TIME, f"it told its state after {took:.2f} s"
    assert np.isfinite(state.width) and not state.problem, f"it is {state}"


def holds_an_object(gripper: GripperDevice, open_width: float, width: float) -> None:
    """Check that the gripper grips an object between its fingers, tells so, and releases it.

    Args:
        gripper: The connected device, with an object between its fingers.
        open_width: Its maximum width [m].
        width: Width of the object [m].
    """
    assert gripper.grasp(0.0, SPEED, FORCE) is True, "it says that it grips nothing"
    for _ in range(2):
        state = gripper.read()
        assert state.is_grasped and abs(state.width - width) < WIDTH_ERROR, f"it is {state}"
        time.sleep(0.5)
    moves_to_widths(gripper, open_width)


GRIPPER_CONTRACT = (
    moves_to_widths,
    grips_nothing_where_nothing_is,
    refuses_a_width_that_it_cannot_reach,
    tells_its_state_at_once,
)


def _assert_width(gripper: GripperDevice, width: float) -> None:
    state = gripper.read()
    assert abs(state.width - width) < WIDTH_ERROR, f"at {width:g} m its width is {state.width:g} m"
    assert not state.is_grasped, "it says that it grips something"


def _set_off(station: Station) -> np.ndarray:
    """Begin a motion of the first joint towards zero or away from it; return its goal."""
    arm = station.arm
    goal = arm.q_ref
    goal[0] += -STROKE if goal[0] > 0.0 else STROKE
    arm.move_to_configuration(goal)
    return goal


def _begin_to_move(station: Station) -> None:
    """Wait until the arm has clearly begun its motion."""
    arm = station.arm
    start = arm.q_ref[0]
    _wait(station, lambda: abs(arm.q[0] - start) >= 0.1, LONGEST, "the arm does not move")


def _wait_for_rest(station: Station, measure: Callable[[], object] = lambda: None) -> None:
    """Wait until the arm is at rest; `measure` is called before each tick."""
    arm = station.arm

    def rests() -> bool:
        measure()
        streaming = arm.connection is not None and arm.connection.streaming
        return not arm.busy and arm.at_rest and not streaming

    _wait(station, rests, LONGEST, "the arm moves on")


def _wait(station: Station, condition: Callable[[], bool], timeout: float, problem: str) -> None:
    """Wait in ticks until a condition holds; fail with the problem if it does not in time [s]."""
    try:
        station.step_until(condition, timeout, steps=station.request.steps_per_tick)
    except TimeoutError:
        raise AssertionError(f"{problem} after {timeout:g} s") from None


def _assert_at(station: Station, goal: np.ndarray) -> None:
    off, connection = float(np.abs(station.robot.q - goal).max()), station.arm.connection
    assert connection is not None
    allowed = ARRIVED + connection.steady_state_error
    assert off < allowed, f"the arm is {off:.4f} rad from where it should be"
