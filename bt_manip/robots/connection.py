"""Connections to a real arm and its gripper, each in a process of its own, or both in one."""

import contextlib
import json
import mmap
import os
import subprocess
import sys
import tempfile
import time
import weakref
from collections.abc import Callable, Sequence
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from .connection_worker import ArmReading, Field, SharedReadings
from .device import DeviceError, GripperState
from .motion_limits import MotionLimits
from .payload import Payload

START_TIME = 60.0
"""Longest wall time in which a process starts [s]."""

CONNECT_TIME = 10.0
"""Longest wall time in which an arm is connected [s]."""

HOMING_TIME = 30.0
"""Longest wall time in which a gripper is connected and homed [s]."""

ANSWER_TIME = 3.0
"""Longest wall time without an answer of a connection [s]."""

_COMMAND = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from bt_manip.robots.connection_worker import main
main(int(sys.argv[2]))
"""


class LateError(Exception):
    """A change of a motion came after the setpoint at which it was to take effect."""


class _DeviceConnection:
    """A connection to the process of a device, which ends with its pipe.

    Attributes:
        pipe: The pipe.
        process: The process.

    Raises:
        DeviceError: If the device cannot be reached in time.
    """

    def __init__(
        self, what: str, address: str, limit: float, *message: Any, files: Sequence[int] = ()
    ) -> None:
        self._what, self._address = what, address
        self.pipe, other = Pipe()
        with other:
            environment = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ}
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-c", _COMMAND, json.dumps(sys.path), str(other.fileno())],
                pass_fds=[other.fileno(), *files], stdin=subprocess.DEVNULL, env=environment,
                process_group=0,  # Ctrl-C reaches this process only
            )  # fmt: skip
        self._end: Callable[[], object] = weakref.finalize(self, _end, self.process, self.pipe)
        try:
            self.pipe.send(message)
            self.receive(START_TIME)
            answer = self.receive(limit)
        except BaseException:
            self.process.kill()
            self._end()
            raise
        if answer[0] == "error":
            self._end()
            raise DeviceError(answer[1])
        self.about = answer[1:]

    def receive(self, limit: float = ANSWER_TIME) -> Any:
        """Return the next message.

        Raises:
            DeviceError: If there is none within a wall time [s], or the process has ended.
        """
        try:
            if self.pipe.poll(limit):
                return self.pipe.recv()
        except (EOFError, OSError):
            with contextlib.suppress(subprocess.TimeoutExpired):
                code = self.process.wait(1.0)
                raise self.error(f"its process has ended (exit code {code})") from None
        raise self.error(
            f"no answer within {limit:g} s", "is it switched on, and is no other client connected?"
        )

    def error(self, problem: str, remedy: str = "") -> DeviceError:
        """Return an error of the device."""
        return DeviceError(f"{self._what}: {problem}", self._address, remedy)

    def close(self) -> None:
        """Let the process end once the device is at rest."""
        self._end()


class ArmConnection(_DeviceConnection):
    """Sends references to an arm ahead of time, and reads what it measures.

    References are setpoints `CONTROL_STEP` apart, counted since the arm was connected.

    Args:
        factory: ``"module:name"`` of a function that makes the `ArmDevice`.
        address: Its argument.
        limits: Limits that every setpoint is checked against until `set_limits`.

    Attributes:
        setpoint: Number of the last setpoint whose reading was taken.
        last: That reading.
        properties: What the device says about itself and its host.
        steady_state_error: That of the device [rad].
        gripper_pipe: Leads to the gripper on the arm's connection; None where it has none.

    Raises:
        DeviceError: If the arm cannot be reached.
    """

    def __init__(self, factory: str, address: str, limits: MotionLimits) -> None:
        joints = len(limits.lower)
        with tempfile.TemporaryFile() as file:
            file.truncate(SharedReadings.size(joints))
            self._memory = mmap.mmap(file.fileno(), SharedReadings.size(joints))
            self.gripper_pipe: Connection | None
            self.gripper_pipe, other = Pipe()
            files = [file.fileno(), other.fileno()]
            with other:
                super().__init__(
                    "arm", address, CONNECT_TIME, "arm", *files, factory, address, limits,
                    files=files,
                )  # fmt: skip
        self._shared = SharedReadings(self._memory, joints)
        self.properties: dict[str, str]
        self.steady_state_error: float
        self.properties, self.steady_state_error, with_gripper = self.about
        if not with_gripper:
            self.gripper_pipe = None
        self.setpoint = 0
        self.setpoint += self.wait(1)
        self.last = self.latest

    # Readings

    @property
    def problem(self) -> str:
        """Why the arm does not move; empty when it is ready."""
        return self._shared.problem

    @property
    def recoverable(self) -> bool:
        """Whether `recover` may clear the problem."""
        return bool(self._shared.header[Field.RECOVERABLE])

    @property
    def streaming(self) -> bool:
        """Whether the arm follows references."""
        return bool(self._shared.header[Field.STREAMING])

    @property
    def longest_gap(self) -> float:
        """Longest wall time between two cycles of a motion [s]."""
        return float(self._shared.header[Field.LONGEST])

    @property
    def lost_cycles(self) -> int:
        """Cycles of motions in which the arm got no reference."""
        return int(self._shared.header[Field.LOST])

    @property
    def lag(self) -> int:
        """Setpoints that have passed since the last reading was taken."""
        return int(self._shared.header[Field.SETPOINT]) - self.setpoint

    def wait(self, setpoints: int) -> int:
        """Wait until this many setpoints have passed since the last reading was taken.

        Returns:
            The setpoints that have passed.

        Raises:
            DeviceError: If the connection does not go on.
        """
        header, began = self._shared.header, time.monotonic()
        seen = header[Field.SETPOINT]
        while (passed := self.lag) < setpoints:
            time.sleep(2e-4)
            if header[Field.SETPOINT] != seen:
                seen, began = header[Field.SETPOINT], time.monotonic()
            elif self.process.poll() is not None:
                raise self.error("its process has ended unexpectedly")
            elif time.monotonic() - began > ANSWER_TIME:
                raise self.error(f"it has stopped reading for {ANSWER_TIME:g} s")
        return passed

    def take(self) -> ArmReading:
        """Take the reading of the next setpoint."""
        self.setpoint += min(self.lag, 1)
        self.last = self._shared.read(self.setpoint)
        return self.last

    @property
    def latest(self) -> ArmReading:
        """The latest reading."""
        return self._shared.read(int(self._shared.header[Field.SETPOINT]))

    # Commands

    def send(self, latency: int, setpoints: np.ndarray) -> None:
        """Send setpoints that replace those from a future one on.

        Args:
            latency: Setpoints after the last taken reading at which they begin.
            setpoints: Positions that end at rest [rad].  # (n, nq)

        Raises:
            LateError: If that setpoint has passed.
            DeviceError: If the arm cannot follow them.
        """
        try:
            self.pipe.send(("setpoints", self.setpoint + latency, np.ascontiguousarray(setpoints)))
        except OSError:
            raise self.error("its process has ended") from None
        problem, detail = self.receive()
        if problem == "late":
            raise LateError
        if problem == "moved":
            raise self.error(f"the arm was moved: {detail}", "plan again from there")
        if problem == "limits":
            raise self.error(f"the motion exceeds a limit: {detail}")
        if problem:
            raise self.error(detail)

    def recover(self) -> None:
        """Clear errors, once the arm is at rest; `problem` tells the result."""
        self.pipe.send(("recover",))

    def set_payload(self, payload: Payload | None) -> None:
        """Set the held object, once the arm is at rest."""
        payload = payload or Payload(0.0)
        arguments = payload.mass, np.array(payload.com), np.array(payload.inertia)
        self.pipe.send(("set_payload", *arguments))

    def set_limits(self, limits: MotionLimits) -> None:
        """Set the limits that every setpoint is checked against, before the first motion."""
        self.pipe.send(("set_limits", limits))


class GripperConnection(_DeviceConnection):
    """Sends commands to a gripper, and reads its state.

    Args:
        factory: ``"module:name"`` of a function that makes the `GripperDevice`; None for that on
            the connection of `arm`.
        address: Its argument.
        arm: The connection to the arm that has it.

    Attributes:
        state: The latest state.
        problem: Why the last command has failed; empty if it has not.
        restorable: Whether it is that of a simulated gripper, which can return to an earlier state.

    Raises:
        DeviceError: If it cannot be reached.
    """

    restorable = False

    def __init__(self, factory: str | None, address: str, arm: ArmConnection | None = None) -> None:
        if factory is not None:
            super().__init__("gripper", address, HOMING_TIME, "gripper", factory, address)
        elif arm is None or arm.gripper_pipe is None:
            raise DeviceError("there is no gripper", address)
        else:
            self._what, self._address = "gripper", address
            self.pipe, self.process = arm.gripper_pipe, arm.process
            self._end = weakref.finalize(self, self.pipe.close)  # the arm ends the process
            kind, *reason = self.receive(HOMING_TIME)
            if kind == "error":
                raise DeviceError(*reason)
        self._sent = self._done = 0
        self.problem = ""
        self._read(self.receive())

    @property
    def busy(self) -> bool:
        """Whether a command is being executed."""
        return self._done < self._sent

    def command(self, kind: str, *arguments: float) -> None:
        """Send a command of `GripperDevice`; those before it are completed first."""
        self._sent += 1
        self.pipe.send((self._sent, kind, *arguments))

    def update(self) -> None:
        """Read what has arrived.

        Raises:
            DeviceError: If the process has ended.
        """
        try:
            while self.pipe.poll():
                self._read(self.pipe.recv())
        except (EOFError, OSError):
            raise self.error("its process has ended") from None

    def _read(self, message: tuple[Any, ...]) -> None:
        _, done, state = message
        self.state = GripperState(*state)
        if done:
            self._done, _, self.problem = done


def _end(process: subprocess.Popen[bytes], pipe: Connection) -> None:
    pipe.close()
    try:
        process.wait(5.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
