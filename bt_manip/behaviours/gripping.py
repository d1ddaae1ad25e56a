"""Base class of behaviours that approach an object to grip it."""

from bt_manip.grasping import GraspPlanner

from .arm_behaviour import MotionBehaviour


class GrippingBehaviour(MotionBehaviour):
    """Plan a grasp of an object and move."""

    _grasp_planner: GraspPlanner | None = None

    @property
    def grasp_planner(self) -> GraspPlanner:
        """Grasp planner of the selected robot."""
        if self._grasp_planner is None or self._grasp_planner.arm is not self.arm:
            self._grasp_planner = GraspPlanner(self.cell, self.arm)
        return self._grasp_planner
