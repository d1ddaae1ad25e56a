"""Plan grasps of objects."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm
from bt_manip.cell import Cell
from bt_manip.grippers import solids_of
from bt_manip.robots import GraspCandidate, GraspGenerator, Robot

from .grasp_search import GraspPlan, GraspSearch
from .grip_friction import check_friction
from .gripper_clearance import MAX_PENETRATION, GripperClearance
from .ranking import GraspRanking
from .rejections import Rejections


class GraspPlanner:
    """Chooses grasps of objects: the best feasible one by cost.

    Candidates are ranked by their geometry. In that order, equally good ones together, they are
    checked until one passes: clearance of the gripper, inverse kinematics of the pre-grasp pose,
    a collision-free straight approach, and a free lift. Of the configurations that pass, the one
    nearest to the present one is taken.

    Objects of any shape are sampled once after each compile and change of friction, with a fixed
    seed: an object has the same candidates in every run. An object that would slip even at the
    gripper's maximum force has none.

    Attributes:
        arm: The arm that grips.
    """

    def __init__(self, cell: Cell, arm: Arm) -> None:
        """Plan for an arm in a cell."""
        self._cell, self.arm = cell, arm
        self._known: dict[str, tuple[GripperClearance, GraspGenerator]] = {}
        self._generation = -1
        self._friction = b""  # of all geoms, at which the generators were made

    def plan(self, name: str, heights: Sequence[float], centre: np.ndarray) -> GraspPlan:
        """Choose a grasp and the configuration from which the tool approaches it.

        Args:
            name: The object.
            heights: Heights of the pre-grasp pose over the object's centre, along the tool's axis,
                of which the first reachable one is taken [m]; limited to `MAX_SIDE_STANDOFF` where
                the approach is not from above.
            centre: The object's centre in the world [m].  # (3,)

        Raises:
            CellError: When there is no such object.
            MotionError: When no grasp is feasible, with the reasons.
        """
        search = self._search(name, self.arm.model.pose(self.arm.q))
        plan = search.best(heights, centre)
        if plan is None:
            raise search.rejections.error()
        return plan

    def nearest(self, name: str, T_now: pin.SE3) -> tuple[GraspCandidate, pin.SE3]:
        """Return the grasp with clearance whose approach axis is nearest to the tool.

        Args:
            name: The object.
            T_now: Pose of the tool.

        Returns:
            The grasp, and the pose of the tool at it.

        Raises:
            CellError: When there is no such object.
            MotionError: When no grasp has clearance.
        """
        search = self._search(name, T_now)
        found = search.nearest()
        if found is None:
            raise search.rejections.error()
        return found.grasp, found.T_wt

    def check_clearance(self, name: str, T_wt: pin.SE3) -> None:
        """Check that the gripper has clearance at a tool pose.

        Raises:
            MotionError: When it has none, naming the obstacle.
        """
        found = GripperClearance(self._cell, self.arm.robot, [name]).at_pose(T_wt)
        if found.distance < -MAX_PENETRATION:
            rejections = self._rejections(name)
            rejections.no_clearance[found.entity] += 1
            raise rejections.error()

    def _rejections(self, name: str) -> Rejections:
        others = [
            robot_name
            for robot_name, entity in self._cell.entities.items()
            if isinstance(entity, Robot) and entity is not self.arm.robot
        ]
        return Rejections(name, others)

    def _search(self, name: str, T_now: pin.SE3) -> GraspSearch:
        """Rank all grasp candidates of an object in its present pose."""
        cell = self._cell
        cell.find(name)
        gripper = self.arm.robot.needed_gripper
        check_friction(cell, gripper, name)
        friction = cell.model.geom_friction.tobytes()  # overrides change it in place
        if self._generation != cell.generation or self._friction != friction:
            self._generation, self._friction, self._known = cell.generation, friction, {}
        T_wo = cell.pose(name)
        if name in self._known:
            clearance, generator = self._known[name]
            clearance.refresh()
        else:
            clearance = GripperClearance(cell, self.arm.robot, [name])
            com = T_wo.actInv(np.array(cell.data.subtree_com[cell.body_id(name)]))
            generator = gripper.grasp_generator(
                name, solids_of(cell, name), clearance.geom_poses, com, np.random.default_rng(0)
            )
            self._known[name] = clearance, generator
        candidates = generator.candidates(-T_wo.rotation[2])
        ranking = GraspRanking(candidates, T_wo, generator.com, T_now)
        return GraspSearch(self.arm, name, ranking, clearance, self._rejections(name))
