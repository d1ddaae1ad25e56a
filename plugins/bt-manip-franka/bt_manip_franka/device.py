"""The arm: joint positions for Franka's own joint impedance controller."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bt_manip.robots import ArmDevice, DeviceError, DeviceState

from .address import Address, realtime_kernel
from .errors import device_error, libfranka, problem

JOINTS = 7
MAX_LOAD = 3.0  # [kg] of the FR3's data sheet

# Tool frame of the Franka hand in the flange: turned by -45 degrees, 0.1034 m along z
_TURN = np.sqrt(0.5)
R_FT = np.array([[_TURN, _TURN, 0.0], [-_TURN, _TURN, 0.0], [0.0, 0.0, 1.0]])
P_FT = np.array([0.0, 0.0, 0.1034])


class FrankaArm(ArmDevice):
    """A Franka Research 3 by libfranka, `bt_manip_franka.address.Address`."""

    period = 1e-3
    extrapolated_cycles = 20

    def __init__(self, address: str) -> None:
        """Parse the address; `connect` connects."""
        self._address = Address.parse(address)
        self.realtime = self._address.realtime != "ignore"
        self._robot: Any = None
        self._control: Any = None
        self._state: Any = None
        self._aborted = ""  # the motion, for a reason that the state no longer shows
        self._last: np.ndarray | None = None  # reference of this motion

    @property
    def properties(self) -> dict[str, str]:
        """What a report says about the connection."""
        address = self._address
        return {
            "controller": "joint_impedance, by joint positions",
            "realtime_config": "kEnforce" if address.enforces_realtime else "kIgnore",
            "realtime_kernel": "yes" if realtime_kernel() else "no",
            "collision_thresholds": (
                f"{address.collision_torque:g} N m, {address.collision_force:g} N"
            ),
        }

    def connect(self) -> None:
        """Connect, and set the collision thresholds."""
        pf, address = libfranka(), self._address
        realtime = pf.RealtimeConfig
        config = realtime.kEnforce if address.enforces_realtime else realtime.kIgnore
        torques, forces = [address.collision_torque] * JOINTS, [address.collision_force] * 6
        self._robot = self._call(pf.Robot, address.host, config)
        self._call(self._robot.set_collision_behavior, torques, torques, forces, forces)
        self._state = self._call(self._robot.read_once)
        self._aborted = ""

    def close(self) -> None:
        """Disconnect; a motion ends as when the connection breaks."""
        self._control = self._robot = None

    def read(self) -> DeviceState:
        """Return the next state that the controller sends; the last one when not connected."""
        if self._control is not None:
            try:
                self._state, _ = self._control.readOnce()
            except Exception as error:
                self._abort(error)
        if self._control is None and self._robot is not None:
            try:
                self._state = self._robot.read_once()
            except Exception as error:
                self._abort(error)
        if self._robot is None:
            time.sleep(self.period)
        state = self._state
        text, recoverable = problem(state)
        if self._aborted and (self._robot is None or not text):
            text, recoverable = self._aborted, True
        return DeviceState(
            np.array(state.q),
            np.array(state.dq),
            np.array(state.tau_J),
            np.array(state.tau_ext_hat_filtered),
            text,
            recoverable,
            np.array(state.q_d),
            state.time.to_sec(),
        )

    def start(self) -> None:
        """Begin a motion of joint positions under the joint impedance controller."""
        pf, robot = libfranka(), self._connected()
        mode = pf.ControllerMode.JointImpedance
        self._control = self._call(robot.start_joint_position_control, mode)
        self._last = None

    def write(self, q: np.ndarray) -> None:
        """Command a reference; nothing is sent after a problem, which `read` reports."""
        if self._control is not None:
            self._send(q)

    def finish(self) -> None:
        """End the motion where the last reference was."""
        if self._control is not None:
            last = np.array(self._state.q_d) if self._last is None else self._last
            self._send(last, finished=True)
        self._control = None

    def set_payload(self, mass: float, centre: np.ndarray, inertia: np.ndarray) -> None:
        """Set the held object, which Desk's end effector must not include."""
        if self._control is not None:
            raise DeviceError("the payload is set between motions only", self._address.host)
        if not 0.0 <= mass <= MAX_LOAD:
            raise DeviceError(f"the arm carries up to {MAX_LOAD:g} kg, not {mass:g} kg")
        centre = R_FT @ centre + P_FT if mass else np.zeros(3)
        inertia = R_FT @ inertia @ R_FT.T if mass else np.zeros((3, 3))
        self._call(self._connected().set_load, mass, centre.tolist(), inertia.flatten("F").tolist())

    def recover(self) -> None:
        """Clear errors that a person need not; reconnect where the connection is lost."""
        self.read()
        if self._robot is None:
            self.connect()
        if problem(self._state)[1]:
            self._call(self._robot.automatic_error_recovery)
        self._aborted = ""

    def _send(self, q: np.ndarray, finished: bool = False) -> None:
        command = libfranka().JointPositions(q.tolist())
        command.motion_finished = finished
        self._last = q
        try:
            self._control.writeOnce(command)
        except Exception as error:
            self._abort(error)

    def _abort(self, error: Exception) -> None:
        """Note why the motion has ended, or the connection."""
        self._control = None
        self._aborted = device_error(error, self._address.host).what
        if isinstance(error, libfranka().NetworkException):
            self._aborted = f"connection lost: {self._aborted}"
            self._robot = None

    def _connected(self) -> Any:
        if self._robot is None:
            raise DeviceError("not connected", self._address.host)
        return self._robot

    def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except Exception as error:  # pylibfranka's have no common base
            if isinstance(error, libfranka().NetworkException):
                self._robot = None
            raise device_error(error, self._address.host) from None
