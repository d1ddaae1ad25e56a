"""How the arm comes to a grasp, and lifts what it grips."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.arm import MARGIN, Arm
from bt_manip.cell import entity_of
from bt_manip.exceptions import MotionError
from bt_manip.planning import ahead, straight_approach

from .grasp import Grasp
from .gripper_clearance import GripperClearance
from .ranking import Ranked
from .refusals import Refusals

WAYS = 24  # lines to the object that are looked at, at the most
SIDE = 0.12  # [m] from which the tool comes at most, where not from above
LIFT = 0.05  # [m] straight up that has to be free
_SEARCHES = (
    (0, MARGIN),
    (1, MARGIN),
    (8, MARGIN),
    (8, 0.0),
)  # few first: mostly the nearest serves
_FROM_ABOVE = math.cos(math.radians(30.0))
_TOUCHED = -1e-3  # [m] that what is lifted may be inside what it lies beside


class Chosen(NamedTuple):
    """A grasp, how the arm comes to it, and why it is this one."""

    grasp: Grasp
    T_wt: pin.SE3
    """Where the tool grips."""
    q: np.ndarray
    """Where the arm goes first, before it moves straight on along the tool's axis."""  # (nq,)
    back: float
    """How far that is [m]."""
    reason: str
    """What speaks for it, and what was refused."""


class WayIn:
    """Looks for ways to the grasps of one object, as everything stands now."""

    def __init__(self, arm: Arm, name: str, room: GripperClearance, refused: Refusals) -> None:
        """Look for an arm.

        Args:
            arm: The arm.
            name: The object.
            room: Of the hand around it.
            refused: Where what speaks against grasps is counted.
        """
        self._arm, self._name, self._room, self._refused = arm, name, room, refused

    def nearest(self, batch: Sequence[Ranked], height: float, centre: np.ndarray) -> Chosen | None:
        """Find the nearest configuration from which one of several grasps is come to.

        Args:
            batch: Grasps that serve equally well.
            height: How far over the object's middle the tool is first, along its axis [m].
            centre: The object's middle in the world [m].  # (3,)

        Raises:
            MotionError: When the arm reaches a grasp, but not the place before it.
        """
        arm, refused = self._arm, self._refused
        backs = [_back(one.T_wt, height, centre) for one in batch]
        poses = [ahead(one.T_wt, -back) for one, back in zip(batch, backs, strict=True)]
        if arm.world is not None:
            arm.world.refresh()
        best: tuple[float, Chosen] | None = None
        solved = False
        for starts, margin in _SEARCHES:
            if best is not None:
                break
            for found in arm.ik.solutions(poses, arm.q, starts=starts, margin=margin):
                solved = True
                if refused.ways >= WAYS:
                    break
                one, back = batch[found.target], backs[found.target]
                come = self._come(one, found.q, back)
                if come is not None and come[0] >= MARGIN:
                    return come[1]
                if come is not None and (best is None or come[0] > best[0]):
                    best = come
        if best is not None:
            return best[1]
        if not solved:
            self._check_place_before(batch, height)
            refused.unreachable(len(batch))
        return None

    def _come(self, one: Ranked, q: np.ndarray, back: float) -> tuple[float, Chosen] | None:
        """Look at the way from a configuration: how far from a limit it leaves the joints [rad]."""
        arm, refused = self._arm, self._refused
        near = arm.world.collisions(q) if arm.world is not None else []
        if near:
            refused.blocked(entity_of(near[0].second))
            return None
        left, end, error = straight_approach(arm.ik, q, one.T_wt, arm.world)
        if left <= 0.0:
            refused.no_way(error)
            return None
        if not self._lifts(one, end):
            return None
        reason = (
            f"{_describe(one)}; {left:.2f} rad from a limit, "
            f"{arm.ik.distance(q, arm.q):.2f} s away{refused.count()}"
        )
        return left, Chosen(one.grasp, one.T_wt, q, back, reason)

    def _check_place_before(self, batch: Sequence[Ranked], height: float) -> None:
        """Find that only the place before the grasps is beyond reach."""
        arm, name = self._arm, self._name
        above = height > 0.0 and all(_from_above(one.T_wt) for one in batch)
        if above and arm.ik.nearest([one.T_wt for one in batch], arm.q).solved:
            raise MotionError(
                f"{height:g} m over '{name}' is unreachable, though '{name}' is not",
                reason="unreachable",
            )

    def _lifts(self, one: Ranked, q: np.ndarray) -> bool:
        """Tell whether hand and object can go straight up from the grip."""
        room, refused = self._room, self._refused
        steps = [np.array([0.0, 0.0, part * LIFT]) for part in (0.5, 1.0)]
        over = room.carrying(self._name, steps)
        if over.distance < _TOUCHED:
            refused.blocked(over.nearest)
            return False
        if _from_above(one.T_wt):
            return True  # much as it came
        T = one.T_wt
        for step in steps:
            there = room.at(pin.SE3(T.rotation, T.translation + step))
            if there.distance < 0.0:
                refused.blocked(there.nearest)
                return False
        up = pin.SE3(one.T_wt.rotation, one.T_wt.translation + steps[-1])
        error = straight_approach(self._arm.ik, q, up, None).refused
        if error is not None:
            refused.no_way(error)
            return False
        return True


def _back(T_wt: pin.SE3, height: float, centre: np.ndarray) -> float:
    """Give how far before the grip the tool is first [m]."""
    a = T_wt.rotation[:, 2]
    back = max(height + float(a @ (T_wt.translation - centre)), 0.0)
    return back if _from_above(T_wt) else min(back, SIDE)


def _from_above(T_wt: pin.SE3) -> bool:
    return bool(-T_wt.rotation[2, 2] > _FROM_ABOVE)


def _describe(one: Ranked) -> str:
    """Say in words from where a grasp comes and what it costs."""
    tilt = math.degrees(math.acos(float(np.clip(-one.T_wt.rotation[2, 2], -1.0, 1.0))))
    where = "from above" if tilt < 5.0 else f"{tilt:.0f} degrees from upright"
    return f"{where}, {1e3 * one.grasp.width:.0f} mm wide; costs: {one.cost}"
