"""The arm: joint positions for the position mode of its controller."""

import atexit
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any, Literal

import numpy as np

from bt_manip.exceptions import one_line
from bt_manip.robots import ArmDevice, DeviceAddress, DeviceError, DeviceState

from .gripper import Carriages

POLL = 2e-4  # [s] between two looks for a new state
SILENCE = 1.0  # [s] of wall time without one, after which the connection is lost
TIMEOUT = 5.0  # [s] for connecting
REMEDY = "check the address, the cable, and that no other client is connected"


@dataclass(frozen=True)
class Address(DeviceAddress):
    """``HOST`` or ``HOST?key=value&...``.

    Attributes:
        end_effector: The one that is mounted, of the driver's standard ones.
        external_forces: ``"off"`` ignores the controller's estimate: contacts do not stop the arm.
    """

    end_effector: Literal["follower", "leader", "base"] = "follower"
    external_forces: Literal["on", "off"] = "on"


class WidowXAI(ArmDevice):
    """A WidowX AI by Trossen's driver, which sends the last command again and again.

    Arm and gripper share the connection: the controller takes one client.
    """

    period = 2e-3
    realtime = True

    def __init__(self, address: str) -> None:
        """Parse the address; `connect` connects."""
        self._address = Address.parse(address)
        self.gripper = Carriages(self)
        self._driver: Any = None
        self._lock = threading.Lock()  # the gripper's commands come from another thread
        self._problem, self._due = "", 0.0
        self._state = DeviceState(np.zeros(6), np.zeros(6), None, None)
        self._held: np.ndarray | None = None  # the last reference, which the controller keeps

    @property
    def properties(self) -> dict[str, str]:
        """What a report says about the connection."""
        return {"controller": "position", "firmware": self._driver.get_controller_version()}

    def connect(self) -> None:
        """Connect, and hold arm and gripper where they are."""
        self._connect(clear_error=False)

    def close(self) -> None:
        """Disconnect; the driver brakes the joints."""
        if self._driver is not None:
            self._driver.cleanup()
        self._driver = None

    def read(self) -> DeviceState:
        """Return the first state that is a period later, by the controller's clock."""
        if not self._problem:
            self._read_next()
        if not self._problem:
            return self._state._replace(q_held=self._held)
        time.sleep(self.period)
        # Nothing is known any more; the controller brakes the joints of an idle arm.
        at_rest = self._state._replace(v=np.zeros_like(self._state.v), time=0.0)
        return at_rest._replace(problem=self._problem, recoverable=True)

    def write(self, q: np.ndarray) -> None:
        """Command a reference; nothing is sent after a problem, which `read` reports."""
        self._held = q.copy()
        target = trossen().VectorDouble(q.tolist())
        self.call(lambda driver: driver.set_arm_positions(target, 0.0, False))

    def recover(self) -> None:
        """Connect anew, which clears the error, and hold the arm where it is."""
        if self._problem:
            self.close()
            self._connect(clear_error=True)

    def call(self, function: Callable[[Any], Any]) -> Any:
        """Return the result of a function of the driver; None after a problem."""
        with self._lock:
            if self._driver is None or self._problem:
                return None
            try:
                return function(self._driver)
            except Exception as error:  # the driver's have no common base
                self._problem = one_line(error)
                return None

    def _connect(self, clear_error: bool) -> None:
        ta, address = trossen(), self._address
        end = getattr(ta.StandardEndEffector, f"wxai_v0_{address.end_effector}")
        driver = ta.TrossenArmDriver()
        try:
            driver.configure(ta.Model.wxai_v0, end, address.host, clear_error, TIMEOUT)
            driver.set_all_modes(ta.Mode.position)
            held = driver.get_arm_positions()
        except Exception as error:
            raise DeviceError(one_line(error), address.host, REMEDY) from None
        self._driver, self._problem, self._due = driver, "", 0.0
        self._held = np.array(held)
        self._read_next()

    def _read_next(self) -> None:
        end = time.monotonic() + SILENCE
        while (output := self.call(lambda driver: driver.get_robot_output())) is not None:
            now = 1e-6 * output.header.timestamp
            if now >= self._due:
                arm, known = output.joint.arm, self._address.external_forces == "on"
                self._state = DeviceState(
                    np.array(arm.positions),
                    np.array(arm.velocities),
                    np.array(arm.efforts),
                    np.array(arm.external_efforts) if known else None,
                    time=now,
                )
                self._due = max(self._due, now - 0.5 * self.period) + self.period
                return
            if time.monotonic() > end:
                self._problem = f"connection lost: no new state for {SILENCE:g} s"
                return
            time.sleep(POLL)


@cache
def trossen() -> ModuleType:
    """Import the driver, whose log is silenced: it raises exceptions, too.

    Raises:
        DeviceError: If it is not installed.
    """
    try:
        import trossen_arm
    except ImportError as error:
        raise DeviceError(f"trossen_arm cannot be imported: {one_line(error)}") from None
    silence = trossen_arm.TrossenArmDriver.set_logger_backend
    silence(lambda level, name, text: None)
    # The library would release the function after the interpreter has ended, and crash.
    atexit.register(silence, None)
    return trossen_arm
