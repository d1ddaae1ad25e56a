"""Base classes of behaviours that move to a given target."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input
from bt_manip.checks import check_positive
from bt_manip.kinematics import PoseTarget, PositionTarget, Target
from bt_manip.planning import Planner
from bt_manip.registry import Registry

from .arm_behaviour import MotionBehaviour, blend_radius_input
from .poses import pose_input


class Move(MotionBehaviour):
    """A motion with a speed and a tolerance."""

    blend_radius = blend_radius_input()
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")
    tolerance = Input(
        float, default=MotionBehaviour.ARRIVED, doc="Largest error of a joint on arrival [rad]."
    )

    def check_amounts(self) -> None:
        """Check the tolerance too."""
        super().check_amounts()
        check_positive(self.tolerance, "port 'tolerance'", "rad")

    @property
    def largest_error(self) -> float:
        """Largest joint error at which the arm has arrived [rad]."""
        return float(self.tolerance)


class PoseMove(Move):
    """A motion to a pose of the tool, some rotations of which may be free."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")
    free_axis = Input(
        str,
        default="",
        doc="Axis of the tool, x, y or z, about which it may turn; 'all' for any rotation.",
    )
    cone = Input(float, default=0.0, doc="Largest angle by which the free axis may tilt [rad].")

    @property
    def target(self) -> pin.SE3 | Target:
        """The pose, or the target with its free rotations."""
        tool = self.arm.ik.tool
        if self.free_axis == "all":
            return PositionTarget(tool, self.pose.translation)
        if self.free_axis or self.cone:
            return PoseTarget(tool, self.pose, free_axis=self.free_axis or None, cone=self.cone)
        return self.pose


class PlannedMove(Move):
    """A motion around obstacles."""

    planner = Input(
        str, default="", doc="Name of a registered planner; by default that of the run."
    )

    def setup(self, **infrastructure: Any) -> None:
        """Keep the planners and their random generator too."""
        super().setup(**infrastructure)
        self._rng: np.random.Generator = infrastructure["rng"]
        self._planners: Registry[Callable[..., Planner]] = infrastructure["planners"]

    def planning(self) -> dict[str, Any]:
        """Return the planner and the random generator.

        Raises:
            UnknownPartError: When the planner is not registered.
        """
        name = self.planner
        planner: Planner | None = self._planners.create(name) if name else None
        return {"planner": planner, "rng": self._rng}
