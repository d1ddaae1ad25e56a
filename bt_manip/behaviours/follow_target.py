"""Follow a moving object."""

from bt_manip.bt import Input, Status, Traits

from .arm_behaviour import MotionBehaviour, speed_input
from .object_port import ObjectInput
from .poses import centre_pose, nearest_orientation, top_grasp_poses


class FollowTarget(MotionBehaviour):
    """Keep the tool over a moving object.

    The target is updated at each tick. The behaviour runs until it is halted or `duration` has
    passed.
    """

    traits = Traits(commands={"arm"}, leaves={"at_object": None})

    object = ObjectInput(str, doc="Name of the object.")
    height = Input(float, default=0.2, doc="Height of the tool over the object's centre [m].")
    duration = Input(float, default=0.0, doc="Duration [s]; 0: until it is halted.", at_least=0.0)
    speed = speed_input()

    def start(self) -> None:
        """Set the pose over the object as the target."""
        poses = top_grasp_poses(centre_pose(self.cell, self.object), self.height)
        T_wt = self.arm.model.pose(self.arm.target)
        self.arm.follow(nearest_orientation(poses, T_wt), speed=self.speed)

    def update(self) -> Status:
        """Update the target and the remaining time."""
        if self._lost:
            return self.fail(self._forget_carried())
        if self.duration > 0.0 and self.elapsed >= self.duration:
            self.arm.stop()
            return Status.SUCCESS
        if self.arm.fault:
            return self.fail(self.arm.fault)
        status = self.begin_motion(self.start)
        if status is Status.FAILURE:
            self.arm.stop()
        elif self._blocked is None:
            self.feedback_message = f"{self.arm.remaining:.2f} s behind '{self.object}'"
        return status
