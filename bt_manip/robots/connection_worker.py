"""The process that speaks to a real arm or gripper; it knows no vendor and plans nothing.

One thread does everything: the clients of vendors hold Python's lock while they wait for the robot.
A gripper on the arm's connection has a second thread.
Messages come through a pipe, whose end tells that the parent has ended. Readings of the arm go to
memory that both processes share, so that a busy parent never delays a cycle.
"""

import contextlib
import gc
import mmap
import os
import signal
import sys
import threading
import time
from multiprocessing.connection import Connection
from pkgutil import resolve_name
from typing import Any, NamedTuple

import numpy as np

from bt_manip.exceptions import ANY_BUT_INTERRUPT, BtManipError, one_line

from .device import ArmDevice, DeviceError, DeviceState, GripperDevice
from .motion_limits import CONTROL_STEP, MotionLimits

KEPT_SETPOINTS = 8192
"""Setpoints whose readings the shared memory keeps."""

HEADER = 64
"""Numbers before the readings; `Header` has their meaning."""

REST_TIME = 0.1
"""Time at rest after which a motion is ended [s]."""

LONGEST_LOSS = 0.02
"""Robot's time without a reading after which a motion is stopped [s]."""

LONGEST_PAUSE = 1.0
"""Robot's time that passes between two readings at rest, at most [s]."""

MOVED = 0.02
"""Distance of a joint from what is held, beyond the steady-state error, at which it moves [rad]."""

START_OFFSET = 5e-3
"""Largest distance of the first reference from what is held [rad]."""

OFFSET_TIME = 1.0
"""Time in which that distance is reduced to zero [s]."""

PRIORITY = 50
"""Real-time priority of the process, of 1 to 99."""

IDLE_PERIOD = 0.05
"""Time between two readings of a gripper [s]."""

TEXT = 400
"""Bytes of a problem."""


class Field:
    """Places in the header of the shared memory."""

    SETPOINT, STREAMING, LONGEST, LOST, PROBLEM, RECOVERABLE = range(6)


class ArmReading(NamedTuple):
    """A reading of the arm.

    Attributes:
        q: Measured positions [rad].  # (n,)
        v: Measured velocities [rad/s].  # (n,)
        tau: Measured torques [N m]; NaN if unknown.  # (n,)
        tau_external: External torques [N m]; NaN if unknown.  # (n,)
        q_ref: The reference of this cycle, or the configuration held [rad].  # (n,)
    """

    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray
    tau_external: np.ndarray
    q_ref: np.ndarray


class SharedReadings:
    """Readings of the latest setpoints, in memory of two processes, one of which writes."""

    def __init__(self, memory: Any, joints: int) -> None:
        numbers = np.frombuffer(memory, dtype=float, count=HEADER + KEPT_SETPOINTS * 5 * joints)
        self.header = numbers[:HEADER]
        self._readings = numbers[HEADER:].reshape(KEPT_SETPOINTS, 5, joints)
        self._text = np.frombuffer(memory, dtype=np.uint8, offset=numbers.nbytes)

    @staticmethod
    def size(joints: int) -> int:
        """Return the size of the memory [bytes]."""
        return 8 * (HEADER + KEPT_SETPOINTS * 5 * joints) + TEXT

    def write(self, number: int, state: DeviceState, q_ref: np.ndarray) -> None:
        """Write the reading of a setpoint."""
        reading = self._readings[number % KEPT_SETPOINTS]
        reading[0], reading[1], reading[4] = state.q, state.v, q_ref
        reading[2] = np.nan if state.tau is None else state.tau
        reading[3] = np.nan if state.tau_external is None else state.tau_external

    def read(self, number: int) -> ArmReading:
        """Return the reading of a setpoint, a copy."""
        return ArmReading(*self._readings[number % KEPT_SETPOINTS].copy())

    def set_problem(self, text: str, recoverable: bool) -> None:
        """Write why the arm does not move; empty if it does."""
        data = text.encode()[: TEXT - 1].ljust(TEXT, b"\0")
        self._text[:TEXT] = np.frombuffer(data, np.uint8)
        self.header[Field.RECOVERABLE] = recoverable
        self.header[Field.PROBLEM] = bool(text)

    @property
    def problem(self) -> str:
        """Why the arm does not move."""
        if not self.header[Field.PROBLEM]:
            return ""
        return self._text[:TEXT].tobytes().rstrip(b"\0").decode(errors="replace")


class ArmWorker:
    """Streams references to an arm from a table that the parent sends ahead.

    Every table ends at rest. After a fault that the device does not report itself, such as an
    invalid reading, the motion goes on to this end while new setpoints are refused. Setpoints are
    passed over only as far as the vendor's controller extrapolates the reference. Between two
    setpoints, references are interpolated for devices of other periods.
    """

    def __init__(self, device: ArmDevice, pipe: Connection, limits: MotionLimits) -> None:
        self._device, self._pipe, self._limits = device, pipe, limits
        self._setpoints_per_cycle = device.period / CONTROL_STEP
        self._table = np.empty((0, len(limits.lower)))
        self._first = self._setpoint = self._rested = 0
        self._cycle = 0  # since the arm was connected
        self._start, self._offset = 0, np.zeros(len(limits.lower))  # of this motion
        self._time = 0.0  # [s] of the robot, of the last reading
        self._repeated = 0  # readings with the same time, one after the other
        self._streaming = self._orphaned = False
        self._waiting: list[tuple[Any, ...]] = []  # commands for an arm at rest
        self._refused = ""  # why the arm has to recover, where the device does not say it
        self._state: DeviceState | None = None  # the last valid reading
        self._written = np.empty((0, len(limits.lower)))  # the last two references
        self._passed = 1  # cycles from the one to the other

    def end(self, *_: Any) -> None:
        """End, once the arm is at rest."""
        self._orphaned = True

    def run(self, shared: SharedReadings) -> None:
        """Make cycles until the parent has ended and the arm is at rest."""
        header, last = shared.header, time.perf_counter()
        self._header = header
        while not (self._orphaned and not self._streaming):
            state = self._read()
            now = time.perf_counter()
            if self._streaming:
                header[Field.LONGEST] = max(header[Field.LONGEST], now - last)
            last = now
            cycles = self._cycles(state.time)
            before = self._setpoint
            self._cycle += cycles
            self._setpoint = int(self._position + 1e-6)
            if state.problem and self._streaming:
                self._end()
            problem = state.problem or self._refused
            held = _held(state)
            for number in range(before + 1, self._setpoint + 1):
                shared.write(number, state, self._reference(number) if self._streaming else held)
            if problem != shared.problem:
                shared.set_problem(problem, state.recoverable or not state.problem)
            header[Field.STREAMING] = self._streaming
            header[Field.SETPOINT] = self._setpoint
            self._take_messages(state)
            if self._streaming:
                self._write(cycles)
            while self._waiting and not self._streaming:
                self._command(*self._waiting.pop(0))

    def _read(self) -> DeviceState:
        """Return the device's reading; the last valid one, and a fault, where it is invalid."""
        try:
            state = self._device.read()
            problem = state_problem(state, len(self._limits.lower))
            if not problem:
                self._state = state
                return state
        except ANY_BUT_INTERRUPT as error:
            problem = f"the reading failed: {type(error).__name__}: {one_line(error)}"
            time.sleep(self._device.period)  # what a reading waits for
        if self._state is None:
            raise DeviceError(problem)
        self._refused = self._refused or problem
        return self._state._replace(problem="", time=0.0)

    def _cycles(self, now: float) -> int:
        """Return the cycles that count as passed with a reading; a clock that jumps is a fault.

        Args:
            now: The robot's time of the reading [s]; 0 where it has none.
        """
        before, self._time = self._time, now
        if not now or not before:
            return 1
        period = self._device.period
        cycles = (now - before) / period
        if not self._streaming:
            return max(1, round(min(cycles, LONGEST_PAUSE / period)))
        lost = round(min(cycles, 1e9)) - 1
        if lost >= 0:  # readings that repeated a time have passed already
            lost, self._repeated = max(0, lost - self._repeated), 0
            self._header[Field.LOST] += lost
        else:
            self._repeated += 1
        if abs(now - before) > LONGEST_LOSS + period or self._repeated * period > LONGEST_LOSS:
            change = f"went from {before:.4f} to {now:.4f} s"
            self._refused = self._refused or f"the robot's clock {change} in a cycle of a motion"
        return 1 + max(lost, 0) if lost <= self._device.extrapolated_cycles else 1

    def _write(self, cycles: int) -> None:
        """Write the present reference, where it is within the limits; end the motion at rest.

        Args:
            cycles: Cycles since the last reference.
        """
        q = self._reference(self._position) + self._start_offset
        times = self._passed * self._device.period, cycles * self._device.period
        problem = self._limits.reference_problem(np.stack([*self._written, q]), times)
        if not problem:
            try:
                self._device.write(q)
            except ANY_BUT_INTERRUPT as error:
                problem = f"{type(error).__name__}: {one_line(error)}"
        if problem:
            self._refused = self._refused or f"a reference could not be written: {problem}"
            self._end()
            return
        self._written, self._passed = np.stack([self._written[-1], q]), cycles
        self._rested = self._rested + 1 if self._setpoint >= self._end_setpoint else 0
        if self._rested * self._device.period > REST_TIME:
            self._end()

    @property
    def _position(self) -> float:
        """The number of the present setpoint, with its fraction."""
        return self._cycle * self._setpoints_per_cycle

    @property
    def _end_setpoint(self) -> int:
        return self._first + len(self._table) - 1

    def _reference(self, position: float) -> np.ndarray:
        """Return the setpoint of a number, or a cubic through the four nearest of a fraction."""
        number = int(position + 1e-6)
        t = position - number
        if abs(t) < 1e-6:
            return np.asarray(self._table[min(max(number - self._first, 0), len(self._table) - 1)])
        places = np.clip(np.arange(number - 1, number + 3) - self._first, 0, len(self._table) - 1)
        weights = [
            -t * (t - 1.0) * (t - 2.0) / 6.0, (t * t - 1.0) * (t - 2.0) / 2.0,
            -t * (t + 1.0) * (t - 2.0) / 2.0, t * (t * t - 1.0) / 6.0,
        ]  # fmt: skip
        return np.asarray(np.array(weights) @ self._table[places])

    @property
    def _start_offset(self) -> np.ndarray:
        """What is left of the offset of the start, reduced with a minimum-jerk polynomial [rad]."""
        s = min((self._position - self._start) * CONTROL_STEP / OFFSET_TIME, 1.0)
        return np.asarray((1.0 - s**3 * (10.0 - 15.0 * s + 6.0 * s**2)) * self._offset)

    def _end(self) -> None:
        self._streaming, self._rested = False, 0
        try:
            self._device.finish()
        except ANY_BUT_INTERRUPT as error:
            self._refused = self._refused or f"the motion could not be ended: {one_line(error)}"

    def _take_messages(self, state: DeviceState) -> None:
        try:
            while not self._orphaned and self._pipe.poll():
                kind, *arguments = self._pipe.recv()
                if kind == "setpoints":
                    answer = self._splice(state, *arguments)
                    self._header[Field.STREAMING] = self._streaming
                    self._pipe.send(answer)
                elif kind == "set_limits":
                    (self._limits,) = arguments
                else:
                    self._waiting.append((kind, *arguments))
        except (EOFError, OSError):
            self._orphaned = True

    def _command(self, kind: str, *arguments: Any) -> None:
        """Execute a command for an arm at rest."""
        try:
            if kind == "recover":
                self._refused = ""
            getattr(self._device, kind)(*arguments)
        except ANY_BUT_INTERRUPT as error:
            self._refused = one_line(error)

    def _splice(self, state: DeviceState, first: int, setpoints: np.ndarray) -> tuple[str, str]:
        """Take setpoints from a future one on; return whether, and why not.

        Args:
            state: The present state.
            first: Number of the first setpoint.
            setpoints: Positions that end at rest [rad].  # (n, nq)
        """
        if state.problem or self._refused:
            return "problem", state.problem or self._refused
        if first <= self._position + self._setpoints_per_cycle:
            return "late", ""
        begin = max(0, first - self._first)  # 0: in place of a motion that has not begun
        if self._streaming:
            before = self._table[max(0, begin - 3) : begin]
            before = np.concatenate([self._table[:1]] * (3 - len(before)) + [before])
            if begin > len(self._table):
                before = np.repeat(self._table[-1:], 3, axis=0)
        else:
            if moved := self._moved(state, setpoints[0]):
                return "moved", moved
            before = np.repeat(setpoints[:1], 3, axis=0)
        if problem := self._limits.setpoints_problem(before, setpoints):
            return "limits", problem
        if self._streaming:
            # Three before the present one are kept for the differences of the next ones.
            oldest = min(max(self._setpoint - 3, self._first), first)
            kept = self._table[max(0, oldest - self._first) : begin]
            held = np.repeat(self._table[-1:], first - oldest - len(kept), axis=0)
            self._first, self._table = oldest, np.concatenate([kept, held, setpoints])
            return "", ""
        try:
            self._device.start()
        except ANY_BUT_INTERRUPT as error:
            self._refused = one_line(error)
            return "problem", self._refused
        self._table, self._first, self._streaming, self._rested = setpoints, first, True, 0
        self._time, self._repeated = 0.0, 0  # a start may take more than a cycle
        held = _held(state)
        self._start, self._offset = self._setpoint, held - setpoints[0]
        self._written, self._passed = np.repeat(held[np.newaxis], 2, axis=0), 1
        return "", ""

    def _moved(self, state: DeviceState, first: np.ndarray) -> str:
        """Return which joint is elsewhere than at the first reference, or than it is held."""
        held, allowed = _held(state), MOVED + self._device.steady_state_error
        for moved, limit in ((held - first, START_OFFSET), (state.q - held, allowed)):
            joint = int(np.abs(moved).argmax())
            if abs(moved[joint]) > limit:
                return f"joint {joint + 1} by {abs(moved[joint]):.3f} rad"
        return ""


def _held(state: DeviceState) -> np.ndarray:
    """Return the configuration that the controller of an arm holds [rad]."""
    return np.asarray(state.q if state.q_held is None else state.q_held)


def state_problem(state: Any, joints: int) -> str:
    """Return the problem of a device's reading; empty for a valid one.

    Args:
        state: What `ArmDevice.read` has returned.
        joints: The number of joints.
    """
    if not isinstance(state, DeviceState):
        return f"a reading is no DeviceState but {type(state).__name__}"
    for name in ("q", "v", "tau", "tau_external", "q_held"):
        values = getattr(state, name)
        if values is None and name not in ("q", "v"):
            continue
        try:
            array = np.asarray(values, dtype=float)
        except (TypeError, ValueError):
            return f"a reading has a '{name}' that is no array of numbers"
        if name == "q" and array.shape != (joints,):
            return f"the arm has {array.size} joints, the robot of the run has {joints}"
        if array.shape != (joints,):
            return f"a reading has a '{name}' of shape {array.shape}, not ({joints},)"
        if not np.isfinite(array).all():
            return f"a reading has a '{name}' that is not finite"
    if not np.isfinite(state.time):
        return "a reading has a 'time' that is not finite"
    return ""


def _made(factory: str, address: str) -> Any:
    """Make and connect a device, with the real-time priority that it wants.

    Raises:
        BtManipError: If that fails.
    """
    try:
        device = resolve_name(factory)(address)
        if getattr(device, "realtime", False):
            with contextlib.suppress(OSError, AttributeError):  # not permitted, or not on Linux
                policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
                os.sched_setscheduler(0, policy, os.sched_param(PRIORITY))
        device.connect()
    except BtManipError:
        raise
    except Exception as error:
        text = f"{type(error).__name__}: {one_line(error)}"
        raise DeviceError(f"{factory} failed: {text}", address) from error
    return device


def serve_arm(
    pipe: Connection,
    memory: Any,
    factory: str,
    address: str,
    limits: MotionLimits,
    gripper_pipe: Connection | None = None,
) -> None:
    """Connect an arm and stream references to it until the parent ends.

    Args:
        pipe: The parent's messages.
        memory: The memory of `SharedReadings`.
        factory: ``"module:name"`` of a function that makes the `ArmDevice`.
        address: Its argument.
        limits: Limits of setpoints until the parent sends others.
        gripper_pipe: The parent's messages for the gripper that shares the arm's connection.
    """
    try:
        device: ArmDevice = _made(factory, address)
    except BtManipError as error:
        pipe.send(("error", str(error)))
        return
    try:
        joints = len(limits.lower)
        if problem := state_problem(device.read(), joints):
            pipe.send(("error", f"{address}: {problem}"))
            return
        gripper = device.gripper
        pipe.send(("connected", _about(device), device.steady_state_error, gripper is not None))
        if gripper is not None and gripper_pipe is not None:
            sys.setswitchinterval(2e-4)  # a longer one would delay cycles
            arguments = gripper_pipe, gripper
            threading.Thread(target=_serve_connected, args=arguments, daemon=True).start()
        worker = ArmWorker(device, pipe, limits)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, worker.end)
        gc.collect()
        gc.freeze()
        gc.disable()  # a collection would be a gap
        worker.run(SharedReadings(memory, joints))
    finally:
        device.close()


def main(descriptor: int) -> None:
    """Serve the device that the first message names, until the pipe ends."""
    with Connection(descriptor) as pipe:
        kind, *arguments = pipe.recv()
        pipe.send(("started",))
        if kind == "gripper":
            serve_gripper(pipe, *arguments)
            return
        file, gripper, factory, address, limits = arguments
        memory = mmap.mmap(file, SharedReadings.size(len(limits.lower)))
        serve_arm(pipe, memory, factory, address, limits, Connection(gripper))


def _about(device: ArmDevice) -> dict[str, str]:
    scheduling = {}
    if device.realtime:
        fifo = hasattr(os, "SCHED_FIFO") and bool(os.sched_getscheduler(0) & os.SCHED_FIFO)
        scheduling["scheduling"] = "SCHED_FIFO" if fifo else "normal"
    return {**scheduling, **device.properties}


def serve_gripper(pipe: Connection, factory: str, address: str) -> None:
    """Connect a gripper and execute commands until the parent ends."""
    try:
        device: GripperDevice = _made(factory, address)
    except BtManipError as error:
        pipe.send(("error", str(error)))
        return
    _serve_connected(pipe, device)


def _serve_connected(pipe: Connection, device: GripperDevice) -> None:
    """Home a connected gripper and execute commands until the pipe ends; end the pipe."""
    with pipe:
        try:
            device.home()
        except BtManipError as error:
            pipe.send(("error", str(error)))
            return
        try:
            pipe.send(("connected",))
            while True:
                done: tuple[Any, ...] = ()
                try:
                    if pipe.poll(IDLE_PERIOD):
                        number, kind, *arguments = pipe.recv()
                        done = (number, False, "")
                        done = (number, getattr(device, kind)(*arguments) is not False, "")
                    state = tuple(device.read())
                except DeviceError as error:
                    done = (done[0], False, str(error)) if done else ()
                    state = (np.nan, False, str(error))
                pipe.send(("state", done, state))
        except (EOFError, OSError):
            pass
        finally:
            device.close()
