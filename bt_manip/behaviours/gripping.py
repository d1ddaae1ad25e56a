"""Base class of behaviours that approach an object to grip it."""

from bt_manip.grasping import GraspPlanner

from .arm_behaviour import BlendedMotion


class GrippingBehaviour(BlendedMotion):
    """Plan a grasp of an object and move."""

    @property
    def grasp_planner(self) -> GraspPlanner:
        """Grasp planner of the selected robot."""
        planner: GraspPlanner = self._robots[self._robot_name].grasp_planner
        return planner
