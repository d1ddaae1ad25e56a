"""Contract of conditions on objects: they hold only in states in which a person would say so.

The oracle is the construction of the states: nothing of the condition's own code is used.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import Cell, extent
from bt_manip.cell.objects import Box
from bt_manip.testing.behaviour_contract import BehaviourCase

_FAR = np.array([20.0, 20.0, 0.0])  # [m] from everything
_SETTLING = 500  # control steps
_RIM = 0.005  # [m] an object whose bottom is less deep below the top is on the rim
_CLEAR = 0.02  # [m] gap between an object and the bounding box of its destination
_TURNED = (0.0, math.pi / 4)  # [rad] yaw of the destination in the state beside it


@dataclass(frozen=True)
class Judged:
    """A condition in the situation of its example, bound to the station.

    Attributes:
        cell: The cell.
        tree: The tree of the condition alone.
        condition: The condition.
    """

    cell: Cell
    tree: Tree
    condition: Any

    @classmethod
    def of(cls, case: BehaviourCase, **ports: Any) -> Self:
        """Restore the example's situation, and bind a new condition with these ports."""
        station = case.start()
        trial = case.trial(station, **ports)
        return cls(station.cell, trial.tree, trial.behaviour)

    @property
    def name(self) -> str:
        """Name of the object."""
        return str(self.condition.object)

    @property
    def destination(self) -> str:
        """Name of the object at which it is to be."""
        return str(self.condition.read_port(self.condition.destination))

    def check_fails(self, state: str) -> None:
        """Check that the condition does not hold.

        Args:
            state: The present state in words.
        """
        self.condition.begin_cycle()
        status = self.tree.tick()
        condition = type(self.condition).__name__
        assert status is NodeStatus.FAILURE, f"{condition} holds although the object {state}"
        assert self.condition.feedback_message, f"{condition} fails without a reason"

    def put(self, position: np.ndarray, *, settle: int = _SETTLING) -> None:
        """Move the object to a position [m], and let it settle for some control steps."""
        T_wo = pin.SE3(self.cell.pose(self.name).rotation, position)
        self.cell.move(self.name, T_wo, overlap=math.inf)
        self.cell.step(settle)

    def put_on_post(self, position: np.ndarray) -> None:
        """Put the object on a fixed post that touches nothing else."""
        lower = extent(self.cell, self.name)[0][2] - self.cell.pose(self.name).translation[2]
        post = Box(size=(0.02, 0.02, 0.02))
        top = position + np.array([0.0, 0.0, lower - 0.01])
        self.cell.add(post, spatial.pose(top), name="contract_post", free=False, overlap=math.inf)
        self.put(position)


def fails_for_objects_far_away(case: BehaviourCase) -> None:
    """Check that it fails for an object at rest far from everything."""
    judged = Judged.of(case)
    judged.put_on_post(judged.cell.pose(judged.destination).translation + _FAR)
    judged.check_fails("is far away")


def fails_for_objects_that_vanished(case: BehaviourCase) -> None:
    """Check that it fails once the object or the destination has been removed."""
    for which in ("name", "destination"):
        judged = Judged.of(case)
        judged.cell.remove(getattr(judged, which))
        judged.check_fails(f"or its destination has vanished ({which})")


def fails_for_falling_objects(case: BehaviourCase) -> None:
    """Check that it fails for an object that falls past its present place or its destination."""
    for shift in (0.0, 0.1, 0.3):
        judged = Judged.of(case)
        top = extent(judged.cell, judged.destination)[1][2]
        position = judged.cell.pose(judged.destination).translation.copy()
        position[2] = top + shift
        judged.put(position, settle=0)
        dof = judged.cell.model.body_dofadr[judged.cell.body_id(judged.name)]
        judged.cell.data.qvel[dof + 2] = -1.0
        judged.cell.step(5)
        judged.check_fails("is falling")


def fails_beside_turned_destinations(case: BehaviourCase) -> None:
    """Check that it fails for an object at rest beside its destination, turned or not."""
    for yaw in _TURNED:
        for side in range(8):
            judged = Judged.of(case)
            cell, name, destination = judged.cell, judged.name, judged.destination
            T_wd = cell.pose(destination)
            lower, upper = extent(cell, destination, T_wd)
            turned = T_wd * pin.SE3(pin.utils.rotate("z", yaw), np.zeros(3))
            cell.move(destination, turned, overlap=math.inf)
            size = np.ptp(extent(cell, name), axis=0)
            half = 0.5 * (upper - lower) + 0.5 * float(np.linalg.norm(size[:2])) + _CLEAR
            angle = side * math.pi / 4
            direction = np.array([math.cos(angle), math.sin(angle)])
            reach = (half[:2] / np.maximum(np.abs(direction), 1e-9)).min()
            local = 0.5 * (lower + upper)
            local[:2] += reach * direction
            local[2] = lower[2]
            position = turned.act(local) + np.array([0.0, 0.0, 0.5 * size[2] + 1e-3])
            judged.put(position)
            judged.check_fails(f"is beside its destination, turned by {yaw:.2f} rad")


def fails_for_swapped_objects(case: BehaviourCase) -> None:
    """Check that it fails with the names of object and destination exchanged."""
    judged = Judged.of(case)
    names = {"object": judged.destination, judged.condition.destination: judged.name}
    Judged.of(case, **names).check_fails("and its destination are swapped")


def fails_on_the_rim(case: BehaviourCase) -> None:
    """Check that it fails for an object on the rim of a container or socket."""
    if case.cls.destination not in ("container", "socket"):  # type: ignore[attr-defined]
        return
    for side in range(8):
        judged = Judged.of(case)
        cell, name, T_wd = judged.cell, judged.name, judged.cell.pose(judged.destination)
        lower, upper = extent(cell, judged.destination, T_wd)
        angle = side * math.pi / 4
        edge = np.array([math.cos(angle), math.sin(angle)])
        local = 0.5 * (lower + upper)
        local[:2] += 0.5 * (upper - lower)[:2] * edge / np.abs(edge).max()
        local[2] = upper[2] + 0.5 * np.ptp(extent(cell, name), axis=0)[2] + 1e-3
        judged.put(T_wd.act(local))
        bottom, top = extent(cell, name)[0][2], extent(cell, judged.destination)[1][2]
        if bottom > top - _RIM:
            judged.check_fails("is on the rim")


def forgets_earlier_cycles(case: BehaviourCase) -> None:
    """Check that a condition that was evaluated begins a cycle like a new one."""
    used = Judged.of(case)
    for _ in range(5):
        used.tree.tick()
        used.cell.step(10)
    new = Judged.of(case)
    for one in (used, new):
        one.condition.begin_cycle()
    assert used.condition.get_state() == new.condition.get_state(), (
        f"{case.cls.__name__} keeps {used.condition.get_state()} from earlier cycles"
    )


CONDITION_CONTRACT: tuple[Callable[[BehaviourCase], None], ...] = (
    fails_for_objects_far_away,
    fails_for_objects_that_vanished,
    fails_for_falling_objects,
    fails_beside_turned_destinations,
    fails_for_swapped_objects,
    fails_on_the_rim,
)
"""Checks of conditions with a destination, beside `forgets_earlier_cycles` of all conditions;
each raises `AssertionError` if it fails."""
