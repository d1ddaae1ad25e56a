"""Insertion of a held object into a socket, with a limited contact force."""

import math
from collections.abc import Iterator, Mapping

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import (
    Destination,
    ObjectCondition,
    extent,
    feasible_force,
    number_or_auto,
)
from bt_manip.bt import Input, Status
from bt_manip.cell import CellError, bottom_of, surrounds, why_not_released
from bt_manip.planning import ArcTo
from bt_manip_impedance.cartesian_impedance import CartesianImpedance
from bt_manip_impedance.compliant_motion import CompliantMotion

STANDOFF = 0.005
"""Height of the object's bottom over the socket before the insertion [m]."""

DEPTH_TOLERANCE = 0.002
"""Tolerance of the depth of an inserted object [m], due to the compliance of the tool."""

CAUGHT = 0.0015
"""Depth at which an object is in the hole during a search [m]; tilted objects are less deep."""

STEP = 0.0025
"""Distance between the places at which a socket may surround an inserted object [m]."""

PITCH = 0.0005
"""Distance between the turns of the spiral [m], less than the clearance of holes."""

LOWERING_SPEED = 0.04
"""Speed before the contact of a search, as a fraction of the limits."""

SEARCH_SPEED = 0.2
"""Speed on the spiral, as a fraction of the limits; about 20 mm/s."""

MAX_FORCE = 30.0
"""Contact force at which it gives up, if the arm can exert it [N]."""

PRESS_FORCE = 6.0
"""Force on the socket in a search, if the grip can hold it [N]."""

STIFFNESS = 1000.0
"""Stiffness of controllers other than `CartesianImpedance` [N/m]."""

DOWN = np.array([0.0, 0.0, -1.0])

IN_HOLE = 0.005
"""Distance from the axis of a hole within which the bottom of an object is over or in it [m]."""

LOWERING, SEARCHING, PUSHING = "lowering", "searching", "pushing"


class Insert(CompliantMotion):
    """Insert the held object straight down into a socket, with a compliant controller.

    The arm positions the object over the socket with its own controller, switches to a compliant
    one, and moves down with contact allowed: an object that meets the rim is guided in by the
    contact instead of jamming.

    With a `search` radius, the hole may be beside the centre of the socket. The object is pressed
    on the socket with a force of stiffness times `press`, and slides on a spiral around the centre
    until it falls into the hole (spiral search, S. Chhatpar and M. Branicky, IROS 2001). By
    friction it lags behind the spiral by the coefficient of friction times `press`; increase the
    radius by this lag.
    """

    memory = (*CompliantMotion.memory, "_phase", "_last_force")

    object = Input(str, doc="Name of the held object.")
    socket = Input(str, doc="Name of the object with the hole, whose axis is its z axis.")
    depth = Input(float, default=0.03, doc="Depth of the insertion [m].")
    max_force = number_or_auto(
        "Contact force at which it gives up [N]; auto: 30, or 0.8 of the arm's maximum force if "
        "lower."
    )
    speed = Input(float, default=0.1, doc="Speed of the insertion, as a fraction of the limits.")
    approach_speed = Input(
        float, default=1.0, doc="Speed of the motion over the socket, as a fraction of the limits."
    )
    search = Input(
        float,
        default=0.0,
        doc="Radius of the search for the hole around the centre [m]; 0: none.",
        at_least=0.0,
    )
    press = number_or_auto(
        "Depth of the reference below the socket's top in a search [m]; auto: for a force of 6 N "
        "at the controller's stiffness, or 0.8 of the grip's maximum force if lower.",
        at_least=0.0,
    )

    _phase = LOWERING
    _last_force = 0.0  # [N] force at the last tick

    def start(self) -> None:
        """Move the object over the socket."""
        if self.object not in self.gripper.held:
            raise CellError(f"the gripper does not hold '{self.object}'")
        self.controllers.get(self.controller)  # raises an error if there is none
        self.arm.move_to_pose(self._tool_pose(STANDOFF), speed=self.approach_speed)

    def update(self) -> Status:
        """Move over the socket, search for the hole, and push until the depth is reached."""
        if not self._compliant:
            return super().update()
        now = self.force
        force, self._last_force = min(now, self._last_force), now  # ignores impacts
        top, bottom = extent(self.cell, self.socket)[1][2], extent(self.cell, self.object)[0][2]
        depth = float(top - bottom)
        self.feedback_message = f"{self._phase}, {1e3 * depth:.1f} mm deep, {force:.1f} N"
        if force > self._limit:
            return self.fail(
                f"'{self.object}' is {1e3 * depth:.1f} mm deep in '{self.socket}' and meets "
                f"{force:.1f} N, at most {self._limit:.3g} N are allowed"
            )
        if depth >= self.depth - DEPTH_TOLERANCE:
            return Status.SUCCESS
        if self._phase in (LOWERING, SEARCHING) and depth >= CAUGHT:
            self._phase = PUSHING
            return self.begin_motion(self._push)
        if self.arm.moving:
            return Status.RUNNING
        if self._phase == LOWERING:
            self._phase = SEARCHING
            return self.begin_motion(self._search)
        if self.has_stopped():
            searched = f", found no hole within {1e3 * self.search:.1f} mm," if self.search else ""
            return self.fail(
                f"'{self.object}' stopped {1e3 * depth:.1f} mm deep in '{self.socket}'{searched} "
                f"expected {1e3 * self.depth:.1f} mm"
            )
        return Status.RUNNING

    def arrived(self) -> Status:
        """Switch to the compliant controller and move down."""
        self._phase, self._ended, self._last_force = LOWERING if self.search else PUSHING, None, 0.0
        limit = self.max_force
        self.become_compliant(feasible_force(MAX_FORCE, self.arm, DOWN) if limit is None else limit)
        return self.begin_motion(self._lower if self.search else self._push)

    def _lower(self) -> None:
        depth, active = self.press, self.controllers.controller
        if depth is None:
            stiffness = active.stiffness[2] if isinstance(active, CartesianImpedance) else STIFFNESS
            depth = feasible_force(PRESS_FORCE, self.arm, DOWN, self.grip_force) / stiffness
        self.arm.move_linear(self._tool_pose(-depth), speed=LOWERING_SPEED, contact=True)

    def _search(self) -> None:
        """Follow a spiral of half circles around the centre of the socket."""
        start = self.arm.model.pose(self.arm.q)
        steps = [
            ArcTo(via, pin.SE3(start.rotation, end))
            for via, end in spiral(start.translation, self.search, PITCH)
        ]
        self.arm.move_path(steps, SEARCH_SPEED, blend=PITCH, contact=True)

    def _push(self) -> None:
        """Move down into the hole, at the position where it caught the object, or at the centre."""
        target = self._tool_pose(-self.depth, centred=not self.search)
        self.arm.move_linear(target, speed=self.speed, contact=True)

    def _tool_pose(self, height: float, *, centred: bool = True) -> pin.SE3:
        """Return the tool pose with the object upright over the socket.

        Args:
            height: Height of the object's bottom over the socket's top [m].
            centred: Whether its bottom is on the socket's axis, instead of its present position.
        """
        T_wo = self.cell.pose(self.object)
        bottom = T_wo.act(bottom_of(self.cell.find(self.object)).translation)
        goal = self.cell.pose(self.socket).translation.copy() if centred else bottom.copy()
        goal[2] = extent(self.cell, self.socket)[1][2] + height
        up = T_wo.rotation[:, 2]
        R = pin.Quaternion.FromTwoVectors(up, np.array([0.0, 0.0, 1.0])).matrix()
        return pin.SE3(R, goal - R @ bottom) * self.T_wt


def spiral(
    centre: np.ndarray, radius: float, pitch: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the half circles of a horizontal spiral, by their middle and end points.

    The radius grows by half the pitch with each half circle; consecutive ones are tangential.

    Args:
        centre: Start of the spiral [m].  # (3,)
        radius: Radius of the covered circle [m].
        pitch: Distance between its turns [m].
    """
    start, sign = np.array(centre, dtype=float), 1.0
    for i in range(1, 2 * math.ceil(radius / pitch) + 2):
        r = 0.5 * pitch * i - 0.25 * pitch
        end = start + np.array([2.0 * sign * r, 0.0, 0.0])
        yield 0.5 * (start + end) + np.array([0.0, sign * r, 0.0]), end
        start, sign = end, -sign


class IsInserted(ObjectCondition):
    """Check that an object is at rest in the hole of a socket, released.

    The hole is where the socket surrounds the object's axis closely: its own axis that is nearest
    to the z axis of the socket. Its end is deep in the hole, or beyond it if its other end sticks
    out; if that end is in the hole, too, as after an insertion from below, the surrounded length
    counts.
    """

    destination = "socket"

    socket = Input(str, doc="Name of the object with the hole.")
    depth = Input(float, default=0.03, doc="Minimum depth [m].")

    def why_not(self) -> str:
        """Search for a place where the socket surrounds the object, at this depth or deeper."""
        cell, name, socket = self.cell, self.object, self.socket
        axis = cell.pose(socket).rotation[:, 2]
        if reason := why_not_released(cell, name):
            return reason
        T_wo = cell.pose(name)
        along = int(np.argmax(np.abs(T_wo.rotation.T @ axis)))
        lower, upper = extent(cell, name, T_wo)
        size, centre = upper - lower, T_wo.act(0.5 * (lower + upper))
        width = float(np.delete(size, along).max())
        up = T_wo.rotation[:, along] * np.sign(T_wo.rotation[:, along] @ axis)
        end = centre - 0.5 * size[along] * up
        length, needed = size[along], max(self.depth - DEPTH_TOLERANCE, 0.0)
        inside = [
            place
            for place in np.arange(needed % STEP, length, STEP)  # `needed` is one of them
            if surrounds(cell, socket, (end + place * up)[None], axis, within=width)
        ]
        if inside:
            sticks_out = inside[-1] + STEP < length
            depth = inside[-1] if sticks_out else inside[-1] - inside[0] + STEP
            if depth >= needed - 1e-9:
                return ""
        return f"'{name}' is not {1e3 * self.depth:.3g} mm deep in a hole of '{socket}'"

    def places(self) -> Mapping[str, Destination]:
        """Return the place over the hole and in it."""
        hole, (bottom, top) = self._hole(), extent(self.cell, self.socket, self._T_ws)
        lower, upper = np.append(hole - IN_HOLE, bottom[2]), np.append(hole + IN_HOLE, top[2])
        return {self.object: Destination(self._T_ws, lower[None], upper[None])}

    def progress(self) -> float:
        """Return the depth in the hole relative to the required one."""
        top = extent(self.cell, self.socket, self._T_ws)[1][2]
        lower, upper = extent(self.cell, self.object)
        at = self._T_ws.actInv(np.array([*(0.5 * (lower + upper))[:2], lower[2]]))
        depth = float(top - at[2]) if np.abs(at[:2] - self._hole()).max() <= IN_HOLE else 0.0
        return min(max(depth / max(self.depth, STEP), 0.0), 1.0)

    @property
    def _T_ws(self) -> pin.SE3:
        return self.cell.pose(self.socket)

    def _hole(self) -> np.ndarray:
        """Return the middle of the hole in the frame of the socket [m]."""  # (2,)
        offset = getattr(self.cell.find(self.socket), "parameters", {}).get("offset", (0.0, 0.0))
        middle = np.mean(extent(self.cell, self.socket, self._T_ws), axis=0)
        return np.asarray(middle[:2] + offset)
