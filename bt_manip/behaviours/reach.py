"""Approach to an object."""

import pinocchio as pin

from bt_manip.bt import Input, Traits
from bt_manip.exceptions import MotionError
from bt_manip.planning import translate_along_tool_z
from bt_manip.robots import GraspCandidate

from .arm_behaviour import MotionBehaviour, blend_radius_input, speed_input
from .object_port import ObjectInput
from .poses import centre_pose


class Reach(MotionBehaviour):
    """Approach an object on a straight line, with clearance of the open gripper."""

    traits = Traits(commands={"arm"}, needs={"open"}, leaves={"at_object": True})

    blend_radius = blend_radius_input()
    object = ObjectInput(str, doc="Name of the object.")
    height = Input(
        float,
        default=None,
        doc="Height of the tool over the object's centre [m]; by default that of the grasp.",
    )
    speed = speed_input()
    grasp = Input(
        str,
        default="",
        doc="The grasp; by default the one chosen by Hover, or the nearest to the tool.",
    )

    def start(self) -> None:
        """Move straight to the grasp, on Hover's joint path if it is still valid."""
        planned = None if self.grasp else self.grasp_planner.planned(self.object)
        if planned is not None and self.height is None:
            self.arm.move_linear(planned.T_wt, speed=self.speed, joint_path=planned.approach)
            return
        T_wt = self._grasp_pose()
        if self.height is not None:
            centre, a = centre_pose(self.cell, self.object).translation, T_wt.rotation[:, 2]
            deeper = -self.height - float(a @ (T_wt.translation - centre))
            T_wt = translate_along_tool_z(T_wt, deeper)
        if self.height is not None or self.grasp:  # the nearest grasp has clearance
            self.grasp_planner.check_clearance(self.object, T_wt)
        self.arm.move_linear(T_wt, speed=self.speed)

    def _grasp_pose(self) -> pin.SE3:
        """Return the pose of the tool at the grasp.

        Raises:
            CellError: If there is no such object.
            MotionError: If there is no feasible grasp.
        """
        if not self.grasp:
            return self.grasp_planner.nearest(self.object, self.T_wt)[1]
        try:
            grasp = GraspCandidate.from_text(self.grasp)
        except ValueError as error:
            raise MotionError(str(error), reason="target") from error
        return self.cell.pose(self.object) * grasp.T_ot
