"""Insert a held object into a socket, with a limited contact force."""

from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import MotionBehaviour, extent
from bt_manip.bt import Condition, Input, Status
from bt_manip.cell import Cell, CellError, at_rest

STANDOFF = 0.005
"""Height of the object's bottom over the socket before it is inserted [m]."""

DEPTH_TOLERANCE = 0.002
"""Missing depth at which the object counts as inserted [m]: the springs of the tool give way."""


class Insert(MotionBehaviour):
    """Insert what the gripper holds straight down into a socket, under a compliant controller.

    The arm positions the object over the socket with its own controller, switches to a compliant
    one, and moves down with contact allowed: an object that meets the rim is guided in by the
    contact instead of jamming. Whatever the outcome, the arm returns to its own controller once it
    is at rest.
    """

    memory = (*MotionBehaviour.memory, "_pushing", "_tare", "_last_force")

    object = Input(str, doc="Name of the held object.")
    socket = Input(str, doc="Name of the object with the hole, whose axis is its z axis.")
    depth = Input(float, default=0.03, doc="How deep the object is inserted [m].")
    max_force = Input(float, default=30.0, doc="Contact force at which it gives up [N].")
    speed = Input(float, default=0.1, doc="Speed of the insertion, as a fraction of the limits.")
    controller = Input(str, default="cartesian_impedance", doc="Registered compliant controller.")

    _pushing = False
    _tare: tuple[float, ...] = ()  # [N] force at the wrist before contact, in the tool's axes
    _last_force = 0.0  # [N] at the last tick

    def start(self) -> None:
        """Move the object over the socket."""
        self._pushing = False
        if self.object not in self.gripper.held:
            raise CellError(f"the gripper does not hold '{self.object}'")
        self.controllers.get(self.controller)  # raises if there is none
        self.arm.move_to_pose(self._tool_pose(STANDOFF))

    def update(self) -> Status:
        """Move over the socket, then push until the depth is reached."""
        if not self._pushing:
            return super().update()
        now = float(np.linalg.norm(self.arm.robot.wrist_wrench().force - np.array(self._tare)))
        force, self._last_force = min(now, self._last_force), now  # an impact is no sustained force
        depth = -self._height()
        self.feedback_message = f"{1e3 * depth:.1f} mm deep, {force:.1f} N"
        if force > self.max_force:
            return self.fail(
                f"'{self.object}' is {1e3 * depth:.1f} mm deep in '{self.socket}' and meets "
                f"{force:.1f} N, at most {self.max_force:g} N are allowed"
            )
        if depth >= self.depth - DEPTH_TOLERANCE:
            return Status.SUCCESS
        if self.arm.moving:
            return Status.RUNNING
        self._ended = self.cell.time if self._ended is None else self._ended
        if self.cell.time - self._ended > self.SETTLING:
            return self.fail(
                f"'{self.object}' stopped {1e3 * depth:.1f} mm deep in '{self.socket}', expected "
                f"{1e3 * self.depth:.1f} mm"
            )
        return Status.RUNNING

    def arrived(self) -> Status:
        """Switch to the compliant controller and move down."""
        self._pushing, self._ended, self._last_force = True, None, 0.0
        self._tare = tuple(self.arm.robot.wrist_wrench().force.tolist())
        self.controllers.switch(self.controller)
        return self.begin_motion(self._push)

    def terminate(self, new_status: Status) -> None:
        """Stop, and return to the arm's own controller."""
        if self._pushing:
            self._pushing = False
            if self.arm.busy:
                self.arm.stop()
            self.controllers.return_to_default()
        super().terminate(new_status)

    def _push(self) -> None:
        self.arm.move_linear(self._tool_pose(-self.depth), speed=self.speed, contact=True)

    def _height(self) -> float:
        return _height_over(self.cell, self.object, self.socket)

    def _tool_pose(self, height: float) -> pin.SE3:
        """Return the tool pose with the object on the socket's axis, at a height over it [m]."""
        T_wt, T_wo, T_ws = self.T_wt, self.cell.pose(self.object), self.cell.pose(self.socket)
        shift = T_ws.translation - T_wo.translation
        shift[2] = height - self._height()
        return pin.SE3(T_wt.rotation, T_wt.translation + shift)


class IsInserted(Condition):
    """Check that an object rests in a socket."""

    object = Input(str, doc="Name of the object.")
    socket = Input(str, doc="Name of the object with the hole.")
    depth = Input(float, default=0.03, doc="How deep it is inserted at least [m].")

    def setup(self, *, cell: Cell, **_: Any) -> None:
        """Keep the cell."""
        self.cell = cell

    def update(self) -> Status:
        """Measure its depth, inside the outline of the socket."""
        try:
            resting = at_rest(self.cell, self.object)
            depth = -_height_over(self.cell, self.object, self.socket)
            lower, upper = extent(self.cell, self.socket)
        except CellError as error:
            return self.fail(str(error))
        if not resting:
            return self.fail(f"'{self.object}' moves")
        position = self.cell.pose(self.object).translation[:2]
        if (position < lower[:2]).any() or (position > upper[:2]).any():
            return self.fail(f"'{self.object}' is beside '{self.socket}'")
        if depth < self.depth - DEPTH_TOLERANCE:
            return self.fail(f"'{self.object}' is {1e3 * depth:.1f} mm deep in '{self.socket}'")
        return Status.SUCCESS


def _height_over(cell: Cell, name: str, socket: str) -> float:
    """Return the height of an object's bottom over a socket's top [m]."""
    return float(extent(cell, name)[0][2] - extent(cell, socket)[1][2])
