"""Choose a feasible grasp of an object."""

import math
from collections.abc import Iterable, Iterator
from itertools import islice

import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm
from bt_manip.cell import Cell
from bt_manip.robots import Robot

from .approach_planner import MAX_APPROACHES, ApproachPlanner, GraspPlan
from .candidate_generator import CandidateGenerator
from .grasp_candidate import GraspCandidate
from .gripper_clearance import SUFFICIENT_CLEARANCE, GripperClearance
from .hand import measure_hand
from .ranking import COST_TOLERANCE, GraspRanking, RankedGrasp
from .rejections import Rejections
from .solids import solids_of

MAX_CLEARANCE_CHECKS = 128  # grasps whose clearance is measured
BATCH_SIZE = 4  # equally good grasps that are solved together
MAX_BATCHES = 6
MAX_PENETRATION = 3e-3  # [m]; collision shapes of grippers are a little thicker than grippers

_AT_PREGRASP = 0.05  # [rad] of tool distance up to which the tool is already at the pre-grasp pose
_CLOSING_MARGIN = 3e-3  # [m] opening, on each side of the contacts, down to which fingers are free
_CLOSING_STEP = 0.012  # [m] between checked finger positions: the thickness of a finger
_MAX_CLOSING_PENETRATION = 0.5e-3  # [m]


class GraspPlanner:
    """Chooses grasps of objects: the best feasible one by cost.

    Candidates are ranked by their geometry. In that order, equally good ones together, they are
    checked until one passes: clearance of the gripper, inverse kinematics of the pre-grasp pose,
    a collision-free straight approach, and a free lift. Of the configurations that pass, the one
    nearest to the present one is taken.

    Objects of any shape are sampled once per compiled model, with a fixed seed: an object has the
    same candidates in every run.

    Attributes:
        arm: The arm that grips.
    """

    def __init__(self, cell: Cell, arm: Arm) -> None:
        """Plan for an arm in a cell."""
        self._cell, self.arm = cell, arm
        self._generators: dict[str, CandidateGenerator] = {}
        self._model: object = None

    def plan(self, name: str, height: float, centre: np.ndarray) -> GraspPlan:
        """Choose a grasp and the configuration from which the tool approaches it.

        Args:
            name: The object.
            height: Height of the pre-grasp pose over the object's centre, along the tool's axis
                [m]; limited to `MAX_SIDE_STANDOFF` where the approach is not from above.
            centre: The object's centre in the world [m].  # (3,)

        Raises:
            CellError: When there is no such object.
            MotionError: When no grasp is feasible, with the reasons.
        """
        arm = self.arm
        clearance, ranking = self._rank(name, arm.model.pose(arm.q))
        rejections = self._rejections(name)
        approaches = ApproachPlanner(arm, name, clearance, rejections)
        grasps = self._with_clearance(name, ranking.by_cost(), clearance, rejections)
        for batch in islice(_batches(grasps), MAX_BATCHES):
            if rejections.approaches >= MAX_APPROACHES:
                break
            found = approaches.plan(batch, height, centre)
            if found is not None:
                return found
        raise rejections.error()

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
        clearance, ranking = self._rank(name, T_now)
        rejections = self._rejections(name)
        for one in self._with_clearance(name, ranking.by_distance(), clearance, rejections):
            return one.grasp, one.T_wt
        raise rejections.error()

    def check_clearance(self, name: str, T_wt: pin.SE3) -> None:
        """Check that the gripper has clearance at a tool pose.

        Raises:
            MotionError: When it has none, naming the obstacle.
        """
        found = GripperClearance(self._cell, self.arm.robot, [name]).at_pose(T_wt)
        if found.distance < -MAX_PENETRATION:
            rejections = self._rejections(name)
            rejections.no_clearance(found.entity)
            raise rejections.error()

    def _rejections(self, name: str) -> Rejections:
        robots = [n for n, entity in self._cell.entities.items() if isinstance(entity, Robot)]
        return Rejections(name, robots)

    def _rank(self, name: str, T_now: pin.SE3) -> tuple[GripperClearance, GraspRanking]:
        """Rank all grasps of an object in its present pose."""
        cell = self._cell
        cell.find(name)
        clearance = GripperClearance(cell, self.arm.robot, [name])
        if self._model is not cell.model:
            self._model, self._generators = cell.model, {}
        T_wo = cell.pose(name)
        if name not in self._generators:
            com = T_wo.actInv(np.array(cell.data.subtree_com[cell.body_id(name)]))
            hand = measure_hand(self.arm.robot, clearance.geom_poses)
            self._generators[name] = CandidateGenerator(
                name, solids_of(cell, name), hand, com, np.random.default_rng(0)
            )
        generator = self._generators[name]
        table = generator.candidates(-T_wo.rotation[2])
        return clearance, GraspRanking(table, T_wo, generator.com, generator.hand, T_now)

    def _with_clearance(
        self,
        name: str,
        ranked: Iterable[RankedGrasp],
        clearance: GripperClearance,
        rejections: Rejections,
    ) -> Iterator[RankedGrasp]:
        """Iterate over the grasps with sufficient clearance in their order, then the tight ones.

        A tight one is not postponed when the tool is already at its pre-grasp pose.
        """
        tight = []
        for one in islice(ranked, MAX_CLEARANCE_CHECKS):
            found = clearance.at_pose(one.T_wt)
            if found.distance < -MAX_PENETRATION:
                rejections.no_clearance(found.entity)
            elif not self._fingers_can_close(name, one, clearance):
                rejections.self_obstructed()
            elif found.distance < SUFFICIENT_CLEARANCE and one.tool_distance > _AT_PREGRASP:
                tight.append(one)
            else:
                yield one
        yield from tight

    def _fingers_can_close(self, name: str, one: RankedGrasp, clearance: GripperClearance) -> bool:
        """Return whether the fingers reach the contacts before they touch another part."""
        generator, grasp = self._generators[name], one.grasp
        if generator.primitive:
            return True  # by the choice of the depth
        if clearance.to_entity(name, one.T_wt) < 0.0:
            return False
        hand = generator.hand
        margin = _CLOSING_MARGIN + hand.pad * math.tan(grasp.normal_angle)  # of inclined faces
        widest, width = hand.stroke, grasp.width + 2.0 * margin
        steps = max(1, math.ceil(0.5 * (widest - width) / _CLOSING_STEP))
        try:
            for k in range(1, steps + 1):
                clearance.open(widest + (min(width, widest) - widest) * k / steps)
                if clearance.to_entity(name, one.T_wt) < -_MAX_CLOSING_PENETRATION:
                    return False
        finally:
            clearance.open()
        return True


def _batches(grasps: Iterable[RankedGrasp]) -> Iterator[list[RankedGrasp]]:
    """Group consecutive grasps that are equally good."""
    batch: list[RankedGrasp] = []
    for one in grasps:
        if batch and abs(one.cost.total - batch[0].cost.total) >= COST_TOLERANCE:
            yield batch
            batch = []
        batch.append(one)
        if len(batch) == BATCH_SIZE:
            yield batch
            batch = []
    if batch:
        yield batch
