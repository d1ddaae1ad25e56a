"""Opening a drawer by its handle."""

import math

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.behaviours import (
    MotionBehaviour,
    feasible_force,
    nearest_orientation,
    number_or_auto,
)
from bt_manip.bt import Input, Status
from bt_manip.cell import CellError, why_not_at_rest
from bt_manip_impedance.approach import ApproachCondition, find_of
from bt_manip_impedance.compliant_motion import CompliantMotion
from bt_manip_impedance.drawer import HANDLE, Drawer

MARGIN = 0.005
"""Excess of the pulled distance over the requested opening [m]."""

LAG = 0.03
"""Excess of the final reference over the opening [m], due to the compliance of the tool."""

MAX_DRAWER_SPEED = 5e-3
"""Maximum speed of a drawer at rest [m/s], as for objects."""

MAX_FORCE = 40.0
"""Force on the handle at which it gives up, if arm and grip can exert it [N]."""

OVER, DOWN = "over", "down"


class ReachHandle(MotionBehaviour):
    """Move the open gripper over a drawer's handle, and straight down to it."""

    memory = (*MotionBehaviour.memory, "_phase")

    object = Input(str, doc="Name of the drawer.")
    height = Input(
        float, default=0.12, doc="Height over the handle before moving down [m].", at_least=0.0
    )
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits.", above=0.0, at_most=1.0)

    _phase = OVER

    def start(self) -> None:
        """Move over the handle; half a turn of the gripper makes no difference."""
        self._phase = OVER
        poses = [self._tool_pose(self.height, yaw) for yaw in (0.0, math.pi)]
        self.arm.move_to_pose(poses, speed=self.speed, approach=self.height)

    def arrived(self) -> Status:
        """Move down to the handle."""
        if self._phase == DOWN:
            return super().arrived()
        self._phase = DOWN
        return self.begin_motion(self._move_down)

    def begin_again(self) -> Status:
        """Retry the motion that another robot blocked."""
        return self.begin_motion(self._move_down if self._phase == DOWN else self.start)

    def _move_down(self) -> None:
        poses = [self._tool_pose(0.0, yaw) for yaw in (0.0, math.pi)]
        self.arm.move_linear(nearest_orientation(poses, self.T_wt), speed=self.speed)

    def _tool_pose(self, height: float, yaw: float) -> pin.SE3:
        T_wh = self.cell.pose(self.object) * find_of(self.cell, self.object, Drawer).T_oh
        x_axis = T_wh.rotation[:, 0]
        heading = math.atan2(x_axis[1], x_axis[0])
        return spatial.pointing_down(T_wh.translation + (0.0, 0.0, height), heading + yaw)


class PullOpen(CompliantMotion):
    """Pull a drawer open by its gripped handle, with a compliant controller.

    The tool moves along the axis of the drawer. The compliance accommodates deviations between this
    axis and the arm's motion, and limits the force on a stuck drawer.
    """

    object = Input(str, doc="Name of the drawer.")
    opening = Input(float, default=0.15, doc="Opening [m].", at_least=0.0)
    max_force = number_or_auto(
        "Force on the handle at which it gives up [N]; auto: 40, or 0.8 of the maximum force of "
        "arm and grip if lower."
    )
    speed = Input(float, default=0.2, doc="Fraction of the arm's limits.", above=0.0, at_most=1.0)

    def start(self) -> None:
        """Switch to the compliant controller and pull."""
        drawer = find_of(self.cell, self.object, Drawer)
        if self.opening + MARGIN > drawer.travel:
            raise CellError(f"'{self.object}' opens by {drawer.travel:g} m at most")
        if self.object not in self.gripper.held:
            raise CellError(f"the gripper does not hold '{self.object}'")
        distance = self.opening + LAG - drawer.opening
        pull = self.cell.pose(self.object).rotation @ np.array([-distance, 0.0, 0.0])
        T_wt, limit = self.T_wt, self.max_force
        if limit is None:
            along = pull / np.linalg.norm(pull)
            limit = feasible_force(MAX_FORCE, self.arm, along, self.grip_force)
        self.become_compliant(limit)
        goal = pin.SE3(T_wt.rotation, T_wt.translation + pull)
        self.arm.move_linear(goal, speed=self.speed, contact=True)

    def update(self) -> Status:
        """Pull until the drawer is open, then wait until it is at rest."""
        if self._blocked is not None:
            return super().update()
        drawer, arm = find_of(self.cell, self.object, Drawer), self.arm
        force, opened = self.force, drawer.opening
        self.feedback_message = f"{1e3 * opened:.0f} mm open, {force:.1f} N"
        if opened >= self.opening + MARGIN:
            if arm.moving:
                if not arm.follower.stopping:
                    arm.stop()
                return Status.RUNNING
            settled = self.steady(abs(drawer.speed) < MAX_DRAWER_SPEED)
            return Status.SUCCESS if settled else Status.RUNNING
        if self.object not in self.gripper.held:
            return self.fail(f"the handle of '{self.object}' was lost {1e3 * opened:.0f} mm open")
        if force > self._limit:
            return self.fail(
                f"'{self.object}' is {1e3 * opened:.0f} mm open and holds back with {force:.1f} N, "
                f"at most {self._limit:.3g} N are allowed"
            )
        if arm.moving:
            return Status.RUNNING
        if self.has_stopped():
            return self.fail(
                f"'{self.object}' stopped {1e3 * opened:.0f} mm open, expected "
                f"{1e3 * self.opening:.0f} mm"
            )
        return Status.RUNNING

    def why_infeasible(self) -> str:
        """Compare the thickness of the handle with the gripper."""
        find_of(self.cell, self.object, Drawer)
        thickness, least = HANDLE[1], self.gripper.min_object_width
        if thickness > least:
            return ""
        return (
            f"the gripper closes to {1e3 * least:.1f} mm only, the handle of '{self.object}' is "
            f"{1e3 * thickness:g} mm thick"
        )


class IsOpen(ApproachCondition):
    """Check that a drawer is open and at rest, held or not."""

    object = Input(str, doc="Name of the drawer.")
    opening = Input(float, default=0.15, doc="Minimum opening [m].", above=0.0)

    def why_not(self) -> str:
        """Measure the position and velocity of the slide."""
        drawer = find_of(self.cell, self.object, Drawer)
        if drawer.opening < self.opening:
            return f"'{self.object}' is {1e3 * drawer.opening:.0f} mm open"
        if abs(drawer.speed) > MAX_DRAWER_SPEED:
            return f"'{self.object}' moves at {1e3 * drawer.speed:.0f} mm/s"
        return why_not_at_rest(self.cell, self.object)

    def progress(self) -> float:
        """Return the progress of reaching the handle, holding it, and opening."""
        drawer = find_of(self.cell, self.object, Drawer)
        near = self.closeness((self.cell.pose(self.object) * drawer.T_oh).translation)
        grippers = [one.gripper for one in self.robots.values() if one.gripper is not None]
        held = any(self.object in gripper.held for gripper in grippers)
        opened = min(drawer.opening / self.opening, 1.0)
        return 0.2 * max(near, opened) + 0.2 * max(held, opened) + 0.6 * opened
