"""Grasp planning."""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.cell import Cell, as_object, body_poses, centre_of_mass
from bt_manip.cell.objects import DeclaredGrasp
from bt_manip.grippers import Solid, solids_of
from bt_manip.robots import GraspCandidate, GraspGenerator, Robot

from .grasp_search import CheckedGrasps, GraspPlan, GraspSearch
from .grip_friction import check_friction
from .gripper_clearance import MAX_PENETRATION, GripperClearance
from .ranking import GraspRanking
from .rejections import Rejections

MAX_DISPLACEMENT = 1e-5
"""Displacement of an object up to which its plan is valid, as objects settle [m] and [rad]."""

SITE_PREFIX = "grasp"
"""Prefix of the names of sites that declare grasps."""


class GraspPlanner:
    """Plans grasps of objects: the feasible grasp of lowest cost.

    Candidates are ranked by their geometry and checked in this order, equally good ones together,
    up to the first feasible one. Checks: clearance of the gripper, inverse kinematics of the
    pre-grasp pose, a collision-free straight approach, and a free lift. Of the feasible
    configurations, the one nearest to the present configuration is chosen.

    Objects without simple shapes are sampled once after each compile and change of their shape or
    friction, with a fixed seed: an object has the same candidates in every run and at every pose.
    An object that would slip even at the gripper's maximum force has none.

    Attributes:
        arm: The arm that grips.
        checked: The grasps checked by the last search; None before the first.
    """

    def __init__(self, cell: Cell, arm: Arm) -> None:
        self._cell, self.arm = cell, arm
        self.checked: CheckedGrasps | None = None
        self._generators: dict[str, tuple[bytes, GraspGenerator]] = {}  # keys and generators
        self._around: GripperClearance  # created again after each compile
        self._generation = -1
        self._planned: tuple[str, int, GraspPlan] | None = None  # object, generation of the cell

    def plan(self, name: str, heights: Sequence[float], centre: np.ndarray) -> GraspPlan:
        """Plan a grasp and the pre-grasp configuration from which the tool approaches.

        Args:
            name: The object.
            heights: Heights of the pre-grasp pose over the object's centre along the tool's axis
                [m]; the first reachable one is used. Limited to `MAX_SIDE_STANDOFF` unless the
                approach is from above.
            centre: The object's centre in the world [m].  # (3,)

        Raises:
            CellError: If there is no such object.
            MotionError: If no grasp is feasible; the message has the reasons.
        """
        search = self._search(name, self.arm.model.pose(self.arm.q))
        plan = search.best(heights, centre)
        if plan is None:
            raise search.rejections.error()
        self._planned = name, self._cell.generation, plan
        return plan

    def planned(self, name: str) -> GraspPlan | None:
        """Return the last plan if it is still valid at the start of the next motion.

        The arm has to be at rest at the pre-grasp configuration, or stop there within its blend
        radius; the object must not have moved by more than `MAX_DISPLACEMENT`; and the gripper
        needs clearance.

        Args:
            name: The object.
        """
        cell = self._cell
        if self._planned is None or self._planned[:2] != (name, cell.generation):
            return None
        plan, arm = self._planned[2], self.arm
        start = arm.target if arm.blend_radius else arm.q
        moved = plan.T_wt.actInv(cell.pose(name) * plan.grasp.T_ot)
        if (
            not np.array_equal(plan.q_pregrasp, start)
            or not moved.isIdentity(MAX_DISPLACEMENT)
            or self._clearance(name).at_pose(plan.T_wt).distance < -MAX_PENETRATION
        ):
            return None
        return plan

    def nearest(self, name: str, T_now: pin.SE3) -> tuple[GraspCandidate, pin.SE3]:
        """Return the grasp with clearance and the approach axis nearest to the tool.

        Args:
            name: The object.
            T_now: Pose of the tool.

        Returns:
            The grasp, and the pose of the tool at it.

        Raises:
            CellError: If there is no such object.
            MotionError: If no grasp has clearance.
        """
        search = self._search(name, T_now)
        found = search.nearest()
        if found is None:
            raise search.rejections.error()
        return found.grasp, found.T_wt

    def check_clearance(self, name: str, T_wt: pin.SE3) -> None:
        """Check that the gripper has clearance at a tool pose.

        Raises:
            MotionError: If it has none; the message names the obstacle.
        """
        found = self._clearance(name).at_pose(T_wt)
        if found.distance < -MAX_PENETRATION:
            rejections = self._rejections(name)
            rejections.no_clearance[found.entity] += 1
            raise rejections.error()

    def _clearance(self, name: str) -> GripperClearance:
        """Return the clearance around an object in the present state of the cell."""
        if self._generation != self._cell.generation:
            self._generation = self._cell.generation
            self._generators = {}
            self._around = GripperClearance(self._cell, self.arm.robot, [name])
        else:
            self._around.refresh()
            self._around.ignore([name])
        return self._around

    def get_state(self) -> dict[str, Any] | None:
        """Return the last plan as plain data."""
        if self._planned is None or self._planned[1] != self._cell.generation:
            return None
        name, _, plan = self._planned
        return {
            "object": name,
            "T_ot": plan.grasp.T_ot.homogeneous.tolist(),
            "width": plan.grasp.width,
            "T_wt": plan.T_wt.homogeneous.tolist(),
            "q_pregrasp": plan.q_pregrasp.tolist(),
        }

    def set_state(self, state: dict[str, Any] | None) -> None:
        """Restore a state in the same cell; the approach is planned again."""
        self._planned = self.checked = None
        if state is not None:
            T_ot, T_wt = (pin.SE3(np.array(state[key])) for key in ("T_ot", "T_wt"))
            plan = GraspPlan(
                GraspCandidate(T_ot, state["width"]), T_wt, np.array(state["q_pregrasp"]), ""
            )
            self._planned = state["object"], self._cell.generation, plan

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
        clearance = self._clearance(name)
        T_wo = cell.pose(name)
        solids, com = solids_of(cell, name), centre_of_mass(cell, name)
        declared = declared_grasps(cell, name)
        # It changes with the object's joints and overrides of friction.
        key = _content(solids, com, declared)
        known, generator = self._generators.get(name, (b"", None))
        if generator is None or known != key:
            poses = clearance.geom_poses
            generator = None
            if declared:
                generator = gripper.declared_grasp_generator(name, declared, poses, com)
            if generator is None:
                rng = np.random.default_rng(0)
                generator = gripper.grasp_generator(name, solids, poses, com, rng)
            self._generators[name] = key, generator
        candidates = generator.candidates(-T_wo.rotation[2])
        ranking = GraspRanking(candidates, T_wo, generator.com, T_now)
        search = GraspSearch(self.arm, name, ranking, clearance, self._rejections(name))
        self.checked = search.checked
        return search


def declared_grasps(cell: Cell, name: str) -> list[DeclaredGrasp]:
    """Return the declared grasps of an object, those of its class first.

    Args:
        cell: The cell.
        name: Name of the object.
    """
    model = cell.model
    found = list(as_object(cell.entities[name]).grasps)
    poses = body_poses(model, cell.body_id(name), cell.data.qpos)
    for site in np.flatnonzero(np.isin(model.site_bodyid, list(poses))):
        if model.site(site).name.rpartition("/")[2].startswith(SITE_PREFIX):
            T_bs = spatial.pose(model.site_pos[site], model.site_quat[site])
            is_box = model.site_type[site] == mujoco.mjtGeom.mjGEOM_BOX
            half = model.site_size[site, 1 if is_box else 0]
            found.append(DeclaredGrasp(poses[int(model.site_bodyid[site])] * T_bs, 2 * float(half)))
    return found


def _content(solids: Sequence[Solid], com: np.ndarray, declared: Sequence[DeclaredGrasp]) -> bytes:
    """Return all properties of an object that may change between two compiles, as bytes."""
    parts = [com, *([s.friction, *s.T_os.homogeneous.ravel()] for s in solids)]
    parts += ([g.width, *g.T_og.homogeneous.ravel()] for g in declared)
    return b"".join(np.array(part).tobytes() for part in parts)
