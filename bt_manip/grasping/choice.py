"""Which grasp of an object the arm takes."""

import math
from collections.abc import Iterable, Iterator
from itertools import islice

import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm
from bt_manip.cell import Cell
from bt_manip.robots import Robot

from .candidates import Candidates
from .grasp import Grasp
from .gripper_clearance import ENOUGH, GripperClearance
from .hand import measure_hand
from .ranking import ALIKE, Ranked, Ranking
from .refusals import Refusals
from .solid import solids_of
from .way_in import WAYS, Chosen, WayIn

LOOKED_AT = 128  # grasps whose room is measured, at the most
BATCH = 4  # grasps that serve equally well and are solved together
BATCHES = 6  # at the most
TOO_DEEP = -3e-3  # [m]; shapes of hands are a little thicker than hands
_BEFORE = 0.05  # [rad] that a tool is off which stands before a grasp already
_EARLY = 3e-3  # [m] on each side before which fingers may touch nothing else of the object
_THICK = 0.012  # [m] of a finger


class GraspChoice:
    """Chooses how to grip objects: best first, and no further than to the first that serves.

    Grasps are compared by their geometry alone. Of those that are alike, the hand has to have room
    at them, inverse kinematics has to reach the place before them, far enough from the limits of
    the joints, from there the line to the object has to be free, and the way up after it. Of what
    passes, the configuration nearest to where the arm is serves.

    What a thing of any shape can be gripped by is sampled once for each model that is compiled,
    with a generator of its own: the same thing is gripped alike in every run.

    Attributes:
        arm: For which it chooses.
    """

    def __init__(self, cell: Cell, arm: Arm) -> None:
        """Choose for an arm in a cell."""
        self._cell, self.arm = cell, arm
        self._known: dict[str, Candidates] = {}
        self._model: object = None

    def choose(self, name: str, height: float, centre: np.ndarray) -> Chosen:
        """Choose a grasp and the configuration from which the tool comes straight to it.

        Args:
            name: The object.
            height: How far over the object's middle the tool is first, measured along its axis
                [m]. Where it does not come from above, at most `way_in.SIDE` from the grip.
            centre: The object's middle in the world [m].  # (3,)

        Raises:
            CellError: When there is no such object.
            MotionError: When there is no grasp that serves, with what refuses them.
        """
        arm = self.arm
        room, ranking = self._look(name, arm.model.pose(arm.q))
        refused = self._refusals(name)
        way_in = WayIn(arm, name, room, refused)
        for number, batch in enumerate(self._batches(name, ranking.best_first(), room, refused)):
            if number == BATCHES or refused.ways >= WAYS:
                break
            found = way_in.nearest(batch, height, centre)
            if found is not None:
                return found
        raise refused.error()

    def nearest(self, name: str, T_now: pin.SE3) -> tuple[Grasp, pin.SE3]:
        """Choose the grasp with room that a tool has to turn and move aside least for.

        Args:
            name: The object.
            T_now: Pose of the tool.

        Returns:
            The grasp, and where the tool is then.

        Raises:
            CellError: When there is no such object.
            MotionError: When there is none with room.
        """
        room, ranking = self._look(name, T_now)

        refused = self._refusals(name)
        for one in self._roomy(name, ranking.nearest_first(), room, refused):
            return one.grasp, one.T_wt
        raise refused.error()

    def check_room(self, name: str, T_wt: pin.SE3) -> None:
        """Look whether the hand has room at a pose of the tool.

        Raises:
            MotionError: When it has none, naming what takes it.
        """
        there = GripperClearance(self._cell, self.arm.robot, [name]).at(T_wt)
        if there.distance < TOO_DEEP:
            refused = self._refusals(name)
            refused.no_room(there.nearest)
            raise refused.error()

    def _refusals(self, name: str) -> Refusals:
        """Begin to count what speaks against grasps of an object."""
        robots = [n for n, entity in self._cell.entities.items() if isinstance(entity, Robot)]
        return Refusals(name, robots)

    def _look(self, name: str, T_now: pin.SE3) -> tuple[GripperClearance, Ranking]:
        """Rank all grasps of an object as it lies now."""
        cell = self._cell
        self._cell.find(name)
        room = GripperClearance(cell, self.arm.robot, [name])
        if self._model is not cell.model:
            self._model, self._known = cell.model, {}
        T_wo = cell.pose(name)
        if name not in self._known:
            com = T_wo.actInv(np.array(cell.data.subtree_com[cell.body_id(name)]))
            hand = measure_hand(self.arm.robot, room.placed)
            self._known[name] = Candidates(
                name, solids_of(cell, name), hand, com, np.random.default_rng(0)
            )
        known = self._known[name]
        down = -T_wo.rotation[2]
        return room, Ranking(known.grasps(down), T_wo, known.centre, known.hand, T_now)

    def _roomy(
        self, name: str, ranked: Iterable[Ranked], room: GripperClearance, refused: Refusals
    ) -> Iterator[Ranked]:
        """Give the grasps at which the hand has room, in their order, and then the tight ones.

        Where the tool stands before one already, that had a reason.
        """
        tight = []
        simple = self._known[name].simple
        for one in islice(ranked, LOOKED_AT):
            there = room.at(one.T_wt)
            if there.distance < TOO_DEEP:
                refused.no_room(there.nearest)
            elif not self._clears(name, one, room, simple):
                refused.in_itself()
            elif there.distance < ENOUGH and one.away > _BEFORE:
                tight.append(one)
            else:
                yield one
        yield from tight

    def _clears(self, name: str, one: Ranked, room: GripperClearance, simple: bool) -> bool:
        """Tell whether the fingers come to the two places before they touch anything else of it."""
        if simple:
            return True  # the hand was placed so
        if room.to(name, one.T_wt) < 0.0:
            return False
        hand, grasp = self._known[name].hand, one.grasp
        early = _EARLY + hand.pad * math.tan(grasp.slant)  # where sides are not parallel
        widest, width = hand.stroke, grasp.width + 2.0 * early
        steps = max(1, math.ceil(0.5 * (widest - width) / _THICK))
        try:
            for k in range(1, steps + 1):
                room.open(widest + (min(width, widest) - widest) * k / steps)
                if room.to(name, one.T_wt) < -0.5e-3:
                    return False
        finally:
            room.open()
        return True

    def _batches(
        self, name: str, ranked: Iterable[Ranked], room: GripperClearance, refused: Refusals
    ) -> Iterator[list[Ranked]]:
        """Give grasps with room, as many at once as serve equally well."""
        batch: list[Ranked] = []
        for one in self._roomy(name, ranked, room, refused):
            if batch and abs(one.cost.total - batch[0].cost.total) >= ALIKE:
                yield batch
                batch = []
            batch.append(one)
            if len(batch) == BATCH:
                yield batch
                batch = []
        if batch:
            yield batch
