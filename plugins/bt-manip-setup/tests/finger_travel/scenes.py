"""A cube of any size between the fingers of any robot."""

import mujoco
import numpy as np

from bt_manip.cell import Cell
from bt_manip.cell.objects import Cube
from bt_manip.control import ComputedTorque, Hold
from bt_manip.grasping import GripperClearance
from bt_manip.grippers import solids_of
from bt_manip.spatial import pose
from tests.support.arms import Post


class Scene:
    """A robot at home, its tool pointing down and its fingers open."""

    def __init__(self, robot, place=None):
        self.robot, self.gripper = robot, robot.gripper
        self.control = control = ComputedTorque(robot)
        robot.attach(control)
        self.cell = Cell()
        self.cell.add(robot, place or pose((0.0, 0.0, 0.4)), free=False)
        control.reference = Hold(robot.q)
        mujoco.mj_forward(self.cell.model, self.cell.data)

    def until(self, condition, seconds=3.0):
        """Step until a condition holds; return the largest force of a finger."""
        largest = 0.0
        for _ in range(round(seconds / self.cell.dt)):
            if condition():
                return largest
            self.cell.step()
            largest = max(largest, *self.gripper.forces)
        raise AssertionError(f"not within {seconds} s: {self.gripper.status}")

    def grasp(self, edge):
        """Stand a cube on a post where it is gripped from above, by a planned grasp."""
        with self.cell.editing():
            self.cell.add(
                Cube(size=edge, mass=0.05, friction=0.8), pose((1.0, 1.0, 0.5 * edge)), free=True
            )
        clearance = GripperClearance(self.cell, self.robot, ["cube"])
        generator = self.gripper.grasp_generator(
            "cube", solids_of(self.cell, "cube"), clearance.geom_poses, np.zeros(3),
            np.random.default_rng(0),
        )  # fmt: skip
        down = np.array([0.0, 0.0, -1.0])
        grasps = [g for g in generator.candidates(down) if g.T_ot.rotation[:, 2] @ down > 0.999]
        T_wo = self.robot.tool_pose * grasps[0].T_ot.inverse()
        self.cell.remove("cube")
        with self.cell.editing():
            x, y, z = T_wo.translation
            self.cell.add(Post(0.4 * edge), pose((x, y, z - 0.5 * edge)))
            self.cell.add(Cube(size=edge, mass=0.05, friction=0.8), T_wo, free=True)
        mujoco.mj_forward(self.cell.model, self.cell.data)
