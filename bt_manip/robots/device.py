"""Device interfaces of real arms and grippers, which plugins implement for a vendor."""

import abc
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bt_manip.exceptions import BtManipError


class DeviceError(BtManipError):
    """A device cannot be reached or refuses a command.

    Attributes:
        what: The problem.
        where: Address of the device.
        remedy: What would put it right; empty if unknown.
    """

    def __init__(self, what: str, where: str = "", remedy: str = "") -> None:
        place = f"{where}: " if where else ""
        super().__init__(f"{place}{what}" + (f" ({remedy})" if remedy else ""))
        self.what, self.where, self.remedy = what, where, remedy

    def __reduce__(self) -> tuple[type["DeviceError"], tuple[str, str, str]]:
        """Pickle the arguments, not the message."""
        return type(self), (self.what, self.where, self.remedy)


class DeviceState(NamedTuple):
    """A reading of an arm.

    Attributes:
        q: Measured positions [rad].  # (nq,)
        v: Measured velocities [rad/s].  # (nq,)
        tau: Measured joint torques [N m]; None if unknown.  # (nq,)
        tau_external: External joint torques as the vendor estimates them [N m]; None if unknown:
            contacts are not detected then.  # (nq,)
        problem: Why the arm does not move, such as a reflex or an emergency stop; empty when ready.
        recoverable: Whether `ArmDevice.recover` clears the problem.
        q_held: Configuration that the vendor's controller holds [rad], from which references start;
            None: the measured one.  # (nq,)
        time: The robot's own time [s]; 0 if it tells none. Where it is more than a period later
            than at the last reading, cycles were lost.
    """

    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray | None
    tau_external: np.ndarray | None
    problem: str = ""
    recoverable: bool = False
    q_held: np.ndarray | None = None
    time: float = 0.0


class ArmDevice(abc.ABC):
    """A vendor's arm, whose own controller follows joint positions.

    It is made in a process of its own, by ``factory(address)``, and one thread calls it: `connect`,
    then `read` in each cycle. A motion is `start`, then `write` after each `read`, then `finish`.
    Methods that are not abstract do nothing by default. All raise `DeviceError`; a problem of the
    arm itself, such as a reflex or a lost connection, is in ``DeviceState.problem`` instead, and
    ends the motion.

    Other exceptions, readings that are not finite or of another size, and a clock that stands still
    or jumps by more than 20 ms stop the motion on its path within a second, with the reason as
    `bt_manip.arm.Arm.problem`; where a reference cannot be written, `finish` is called at once.

    A motion starts where the controller holds the arm: references deviate from the planned ones by
    the difference to that, at most 5 mrad, which is reduced in the first second.

    Attributes:
        period: Time between two readings while references are written [s].
        extrapolated_cycles: Lost cycles for which the vendor's controller extrapolates the
            reference: the setpoints of as many are passed over. After more, the motion goes on
            where it was.
        steady_state_error: Largest distance of a joint from what the controller holds [rad], at
            which a motion may start, such as of an arm that sags; 0.02 rad more are tolerated.
        realtime: Whether its process gets a real-time priority where the system permits it.
        gripper: The gripper, where it shares the arm's connection. It is connected with the arm,
            and another thread of the process calls it; None where it is a device of its own.
    """

    period: float = 1e-3
    extrapolated_cycles: int = 0
    steady_state_error: float = 0.0
    realtime: bool = False
    gripper: "GripperDevice | None" = None
    _due = 0.0

    @property
    def properties(self) -> Mapping[str, str]:
        """Description of the device and its connection, for reports."""
        return {}

    @abc.abstractmethod
    def connect(self) -> None:
        """Connect, and check the version and that the arm is of the expected kind."""

    @abc.abstractmethod
    def close(self) -> None:
        """Disconnect; allowed at any time."""

    @abc.abstractmethod
    def read(self) -> DeviceState:
        """Return the present state; during a motion, wait for the next cycle.

        At rest it returns after at most a period, too.
        """

    def wait_for_cycle(self) -> None:
        """Wait for the next cycle by the clock of this machine, for drivers that do not wait.

        Late cycles are not made up for, which would make the arm faster than planned.
        """
        now = time.perf_counter()
        self._due = max(self._due + self.period, now)
        time.sleep(self._due - now)

    def start(self) -> None:  # noqa: B027
        """Begin a motion; the arm is at rest, and the first reference is where it is held."""

    @abc.abstractmethod
    def write(self, q: np.ndarray) -> None:
        """Command the reference of this cycle.

        Args:
            q: Positions [rad].  # (nq,)
        """

    def finish(self) -> None:  # noqa: B027
        """End the motion; the last references were at rest, or there is a problem."""

    def set_payload(  # noqa: B027
        self, mass: float, centre: np.ndarray, inertia: np.ndarray
    ) -> None:
        """Set the held object, between motions.

        Args:
            mass: Mass [kg]; 0 for none.
            centre: Its centre of mass in the tool frame [m].  # (3,)
            inertia: Its inertia about that centre, along the axes of that frame [kg m2].  # (3, 3)
        """

    @abc.abstractmethod
    def recover(self) -> None:
        """Clear errors and reflexes; reconnect where the connection is lost."""


class GripperState(NamedTuple):
    """A reading of a gripper.

    Attributes:
        width: Distance between the fingers [m].
        is_grasped: Whether the last command has gripped an object, as the vendor reports it.
        problem: Why it does not work; empty when ready.
    """

    width: float
    is_grasped: bool
    problem: str = ""


class GripperDevice(abc.ABC):
    """A vendor's gripper, whose commands block.

    It is made in a process of its own, by ``factory(address)``, or is the `ArmDevice.gripper` of
    an arm.
    """

    @abc.abstractmethod
    def connect(self) -> None:
        """Connect."""

    @abc.abstractmethod
    def close(self) -> None:
        """Disconnect; allowed at any time."""

    def home(self) -> None:  # noqa: B027
        """Find the range of the fingers, where that is necessary; nothing is held."""

    @abc.abstractmethod
    def read(self) -> GripperState:
        """Return the present state."""

    @abc.abstractmethod
    def grasp(self, width: float, speed: float, force: float) -> bool:
        """Close and grip; return whether an object is gripped.

        Args:
            width: Expected width of the object [m]; 0 for any.
            speed: Speed of the width [m/s].
            force: Grip force [N].
        """

    @abc.abstractmethod
    def move(self, width: float, speed: float) -> bool:
        """Move to a width [m], with a speed of the width [m/s]; return whether it got there."""


@dataclass(frozen=True)
class Backend:
    """A way to run on a real robot, registered by ``register_backends``.

    Attributes:
        arm: ``"module:name"`` of a function that makes an `ArmDevice` from an address.
        gripper: The same for a `GripperDevice`; None where there is none or the arm brings it.
        controllers: Names under which trees may switch to the vendor's controllers; the first is
            the default.
        address: What an address is, for messages: ``"the controller's host"``.
    """

    arm: str
    gripper: str | None = None
    controllers: tuple[str, ...] = ("joint_impedance",)
    address: str = "the robot's address"
