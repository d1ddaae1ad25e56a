"""Hover over an object."""

from collections.abc import Sequence

from bt_manip.bt import Output, Status, Traits

from .arm_behaviour import MotionBehaviour, blend_radius_input, speed_input
from .automatic import first_reachable, number_or_auto
from .object_port import ObjectInput
from .poses import centre_pose, top_grasp_poses

HOVER_HEIGHTS = (0.4, 0.3, 0.2, 0.15, 0.1, 0.07)
"""Heights over an object, the preferred one first [m]."""


class Hover(MotionBehaviour):
    """Move the tool to the pre-grasp pose over an object, the start of a straight approach.

    The best feasible grasp is chosen: with clearance of the gripper, and a collision-free approach
    within reach. If no grasp from above is feasible, the pose is beside the object. Over a fixed
    object, for which no grasp is planned, the tool points down.
    """

    traits = Traits(commands={"arm"}, leaves={"at_object": False})

    blend_radius = blend_radius_input()
    object = ObjectInput(str, doc="Name of the object.")
    height = number_or_auto(
        "Height of the tool over the object's centre [m]; auto: the first of "
        f"{', '.join(map(str, HOVER_HEIGHTS))} that the arm reaches.",
        at_least=0.0,
    )
    least = number_or_auto(
        "Smallest of these heights to use if the arm does not reach the given one [m]; auto: only "
        "the given one.",
    )
    speed = speed_input()
    grasp = Output(
        str, doc="The grasp: pose of the tool in the object and width, x;y;z;qw;qx;qy;qz;width [m]."
    )

    memory = (*MotionBehaviour.memory, "_reason")

    _reason = ""  # description of the chosen grasp

    def start(self) -> None:
        """Plan a grasp and move to its pre-grasp configuration."""
        self._reason = ""
        T_wo, heights = centre_pose(self.cell, self.object), self._heights()
        if self.cell.model.body_weldid[self.cell.body_id(self.object)] == 0:  # it is fixed
            first_reachable(
                heights,
                lambda height: self.arm.move_to_pose(top_grasp_poses(T_wo, height), self.speed),
            )
            return
        plan = self.grasp_planner.plan(self.object, heights, T_wo.translation)
        self.grasp, self._reason = plan.grasp.to_text(), plan.reason
        self.arm.move_to_configuration(plan.q_pregrasp, speed=self.speed)

    def _heights(self) -> Sequence[float]:
        """Return the candidate heights, the preferred one first [m]."""
        height, least = self.height, self.least
        if height is None:
            return HOVER_HEIGHTS
        lower = () if least is None else (h for h in HOVER_HEIGHTS if least <= h < height)
        return (height, *lower)

    def update(self) -> Status:
        """Wait until the arm has arrived, and describe the grasp."""
        status = super().update()
        if self._reason and status is not Status.FAILURE:
            self.feedback_message = f"{self.feedback_message}; {self._reason}"
        return status
