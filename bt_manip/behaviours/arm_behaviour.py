"""Base classes of behaviours that use the cell or an arm."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input, NodeStatus, Status, Traits
from bt_manip.bt.nodes import Action
from bt_manip.cell import Cell, CellError, entity_of, why_not_at_rest
from bt_manip.control import ControlError
from bt_manip.exceptions import BoundsError, MotionError
from bt_manip.models import ModelError
from bt_manip.registry import UnknownPartError
from bt_manip.robots import GripperError

from .robot_port import RobotPort

if TYPE_CHECKING:
    from bt_manip.scenes import ExpectedObjects

FAILURES = (
    BoundsError, CellError, ControlError, GripperError, ModelError, MotionError, UnknownPartError,
)  # fmt: skip
"""Errors that make a behaviour of the cell fail; all others end the run."""


class CellBehaviour(Action):
    """A behaviour that uses the cell and measures its own simulated time."""

    STEADY = 0.05  # [s] for which a violated condition has to hold again

    memory: ClassVar[tuple[str, ...]] = ("_started", "_violated")

    adds_objects: Sequence[str] = ()
    """Names of the objects that it adds, as patterns; a tree may then name them in ports."""

    _started = 0.0  # [s] simulated
    _violated: float | None = None  # [s] time at which the condition of `steady` was last violated
    _waits = False  # whether it is running but has not started yet

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell, the expected objects of a pose source, and the cell that has physics."""
        self.cell: Cell = infrastructure["cell"]
        self.expected: ExpectedObjects | None = infrastructure.get("poses")
        self.physics: Cell = getattr(self.expected, "physics", None) or self.cell

    def initialise(self) -> None:
        """Start, or fail with the reason."""
        self._started, self._violated = self.cell.time, None
        self.check_bounds()
        self.start()

    def check_bounds(self) -> None:
        """Check that the ports are within their bounds.

        Raises:
            BoundsError: Naming the port.
        """
        for name, port in self.ports.items():
            if port.reads and port.bounds:
                self.read_port(name)

    def _tick(self) -> NodeStatus:
        try:
            if self._waits and self._node_status is NodeStatus.RUNNING:
                return self._start()
            return super()._tick()
        except FAILURES as error:
            return self._finish(self.fail(str(error)))

    def start(self) -> None:
        """Start the motion or command of the behaviour.

        Raises:
            CellError: If an object is not in the cell.
            MotionError: If the motion is not feasible.
            GripperError: If there is no gripper or it rejects the command.
            ModelError: If a model cannot be found.
            UnknownPartError: If a name is not registered.
        """

    def why_infeasible(self) -> str:
        """Return a reason for failure that is known before the start; empty without one."""
        return ""

    @property
    def elapsed(self) -> float:
        """Simulated time since the start of the behaviour [s]."""
        return self.cell.time - self._started

    def steady(self, condition: bool) -> bool:
        """Return whether a condition holds; a condition violated before, for at least `STEADY`.

        Args:
            condition: The present value of the condition; to be given at each tick.
        """
        if not condition:
            self._violated = self.cell.time
        since = -np.inf if self._violated is None else self._violated
        return condition and self.cell.time - since >= self.STEADY - 1e-9

    def wait_for_rest(self, name: str, patience: float, since: float) -> Status:
        """Return whether an object is at rest; fail after a timeout.

        Args:
            name: Name of the object.
            patience: Timeout [s].
            since: Simulated time at the start of the wait [s].

        Raises:
            CellError: If the object is no longer in the cell.
        """
        reason = why_not_at_rest(self.cell, name)
        if self.steady(not reason):
            return Status.SUCCESS
        if reason and self.cell.time - since > patience:
            return self.fail(f"{reason}, still after {patience:g} s")
        self.feedback_message = reason or f"'{name}' has come to rest"
        return Status.RUNNING


class ArmBehaviour(RobotPort, CellBehaviour):
    """A behaviour that uses a robot's arm and its gripper.

    If the previous behaviour completes while the arm still moves, it starts once the arm is at
    rest. If the arm stopped by itself meanwhile, it fails with the reason.
    """

    ARRIVED = 5e-3  # [rad]; a controller without an integral leaves some friction uncompensated
    SETTLING = 0.5  # [s]

    needs_rest: ClassVar[bool] = True
    """Whether it starts only when the arm is at rest."""

    memory: ClassVar[tuple[str, ...]] = (
        *CellBehaviour.memory, *RobotPort.memory, "_ended", "_waits",
    )  # fmt: skip

    _ended: float | None = None  # [s] time at which the reference came to rest

    @property
    def largest_error(self) -> float:
        """Largest joint error on arrival [rad]."""
        return self.ARRIVED

    def _start(self) -> NodeStatus:
        self.choose_robot()
        arm = self.arm
        if arm.blend_radius and (self.needs_rest or arm.fault):
            self._ended = self._ended if self._waits else None
            status = self.wait_for_arrival()
            self._waits = status is Status.RUNNING
            if self._waits:
                return NodeStatus.RUNNING
            arm.blend_radius = 0.0
            if status is Status.FAILURE:
                return self._finish(status)
        self._waits = False
        return super()._start()

    def wait_for_arrival(self) -> Status:
        """Return whether the arm has arrived; fail if it stopped by itself or does not settle."""
        arm = self.arm
        if arm.fault:
            return self.fail(arm.fault)
        if arm.paused:
            self.feedback_message = "paused"
            return Status.RUNNING
        if arm.moving:
            self.feedback_message = f"{arm.remaining:.2f} s left"
            return Status.RUNNING
        error = float(np.max(np.abs(arm.q - arm.robot.q)))
        sag = 0.0 if arm.connection is None else arm.connection.steady_state_error
        if error <= self.largest_error + sag:
            return Status.SUCCESS
        if self._ended is None:
            self._ended = self.cell.time
        if self.cell.time - self._ended > self.SETTLING:
            return self.fail(
                f"the arm stopped {error:.4f} rad from its target: {arm.describe_error()}"
            )
        self.feedback_message = f"settling, {error:.4f} rad left"
        return Status.RUNNING

    def yield_to_force(self) -> None:
        """Make an arm at rest compliant until its next motion if an external force acts on it."""
        arm = self.arm
        if arm.at_rest and not (arm.paused or arm.compliant or arm.undisturbed):
            arm.stop(compliant=True)

    def stop_gripper(self) -> None:
        """Stop the gripper, if any."""
        gripper = self._robots[self._robot_name].gripper
        if gripper is not None:
            gripper.stop()

    def held_objects(self) -> list[str]:
        """Return the free objects held by the gripper; none without a gripper."""
        gripper = self._robots[self._robot_name].gripper
        held = () if gripper is None else gripper.held
        return [name for name in held if self.cell.is_free(name)]

    @property
    def T_wt(self) -> pin.SE3:
        """Measured pose of the tool; during a blend, the final pose of the motion."""
        arm = self.arm
        return arm.model.pose(arm.target if arm.blend_radius else arm.robot.q)


def blend_radius_input() -> Input:
    """Declare the port of motions that can be blended with the next one."""
    return Input(
        float,
        default=0.0,
        doc="Distance of the tool from its target at which the next motion may begin [m]; 0: the "
        "arm stops.",
        at_least=0.0,
    )


def speed_input(default: float = 1.0) -> Input:
    """Declare the port of the speed of motions."""
    return Input(
        float, default=default, doc="Fraction of the arm's limits.", above=0.0, at_most=1.0
    )


class GripperBehaviour(ArmBehaviour):
    """A behaviour that opens or closes the gripper, with its port ``patience`` as timeout."""

    needs_gripper = True
    traits = Traits(commands={"gripper"}, leaves={"open": None, "at_object": None, "holding": None})

    def terminate(self, new_status: Status) -> None:
        """Stop the gripper when halted."""
        if new_status == Status.INVALID:
            self.stop_gripper()


class MotionBehaviour(ArmBehaviour):
    """Start a motion, wait until the arm has arrived, and stop it when halted.

    The arm has arrived when the reference has ended and the measured joint positions are within
    `ARRIVED` of it, after at most `SETTLING` of simulated time.

    In a class with the port `blend_radius`, a motion with such a radius completes as soon as the
    tool stays within this radius of its target; the next behaviour's motion may begin meanwhile.

    A motion that another robot blocks is retried every `RETRY`, for up to `wait` seconds.

    A motion with a payload in the gripper fails when the gripper has lost it for `LOST`, as
    contacts may be interrupted for a few milliseconds.
    """

    traits = Traits(commands={"arm"}, leaves={"open": None, "at_object": None, "holding": None})

    RETRY = 0.1  # [s]
    LOST = 0.05  # [s]

    wait = Input(
        float,
        default=10.0,
        doc="Timeout for another robot that blocks the motion, in simulated time [s].",
        at_least=0.0,
    )

    memory: ClassVar[tuple[str, ...]] = (
        *ArmBehaviour.memory, "_blocked", "_tried", "_carried", "_missing",
    )  # fmt: skip
    needs_rest = False

    _blocked: float | None = None  # [s] time since which another robot has blocked the motion
    _tried = 0.0  # [s] of the last attempt
    _carried: Sequence[str] = ()  # objects held by the gripper at the start
    _missing: float | None = None  # [s] time since which it has held none of them

    def initialise(self) -> None:
        """Start the motion."""
        self._started, self._violated = self.cell.time, None
        self._ended = self._blocked = self._missing = None
        self.check_bounds()
        self._carried = self.held_objects() if self.arm.payload is not None else []
        self.begin_motion(self.start)

    @property
    def _radius(self) -> float:
        """The blend radius [m]; 0 if the class declares no such port."""
        return float(self.read_port("blend_radius")) if "blend_radius" in self.ports else 0.0

    def begin_motion(self, begin: Callable[[], None]) -> Status:
        """Start a motion, wait for another robot that blocks it, or fail with the reason.

        After a fault it also waits until the arm has come to rest.

        Args:
            begin: Requests the motion from the arm.
        """
        try:
            self.arm.check_ready()
            begin()
        except MotionError as error:
            if error.reason not in ("robot", "stopping"):
                return self.fail(str(error))
            now = self._tried = self.cell.time
            self._blocked = now if self._blocked is None else self._blocked
            if error.reason == "robot" and now - self._blocked >= self.wait - 1e-9:
                return self.fail(f"{error}, for {self.wait:g} s" if self.wait else str(error))
            self.feedback_message = f"waiting: {error}"
            return Status.RUNNING
        self._blocked = self._ended = None
        return Status.FAILURE if self._node_ended else Status.RUNNING  # `begin` may call `fail`

    def begin_again(self) -> Status:
        """Retry the motion that another robot blocked."""
        return self.begin_motion(self.start)

    def update(self) -> Status:
        """Wait until the arm has arrived, or is within the blend radius."""
        if self._lost:
            return self.fail(self._forget_carried())
        if self._blocked is not None:
            late = self.cell.time >= self._tried + self.RETRY - 1e-9
            return self.begin_again() if late else Status.RUNNING
        status = self.wait_for_arrival()
        if self._missing is not None:
            return status if status is Status.FAILURE else Status.RUNNING
        if status is Status.SUCCESS:
            return self.arrived()
        arm, radius = self.arm, self._radius
        if status is Status.RUNNING and radius and arm.moving and arm.ends_within(radius):
            arm.blend_radius = radius
            return Status.SUCCESS
        return status

    @property
    def _lost(self) -> bool:
        """Whether the gripper has not held the carried object for `LOST`."""
        if not self._carried:
            return False
        held = self.gripper.held
        if any(name in held for name in self._carried):
            self._missing = None
        elif self._missing is None:
            self._missing = self.cell.time
        return self._missing is not None and self.cell.time - self._missing >= self.LOST - 1e-9

    def _forget_carried(self) -> str:
        """Stop without payload; return the reason."""
        name, self._carried = self._carried[0], []
        self.arm.stop()
        self.arm.payload = None
        if name not in self.cell.entities:
            return f"'{name}' was lost during the motion: it is no longer in the cell"
        touched = sorted({entity_of(body) for body in self.cell.contacts.partners(name)})
        where = ", ".join(f"'{other}'" for other in touched) or "nothing"
        return f"'{name}' was lost during the motion; it touches {where}"

    def arrived(self) -> Status:
        """Return the status after arrival; by default SUCCESS."""
        self.feedback_message = "arrived"
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        """Stop the arm when halted during the motion."""
        if new_status == Status.INVALID and self.arm.busy:
            self.arm.stop()
