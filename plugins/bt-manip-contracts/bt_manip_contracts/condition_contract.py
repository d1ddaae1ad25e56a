"""Contract of conditions: they hold only in states in which a person would say so.

The oracle is how the states are made, and bounding boxes; no code of a condition is used.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip import spatial
from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import Cell, MonitoredEntity, extent
from bt_manip.cell.objects import Box
from bt_manip_contracts.behaviour_contract import BehaviourCase

_FAR = np.array([20.0, 20.0, 1.0])  # [m] from everything
_SETTLING = 500  # control steps
_RIM = 0.005  # [m] an object whose bottom is less deep below the top is on the rim
_CLEAR = 0.02  # [m] gap between the object and the bounding box of its destination
_TURNED = (0.0, math.pi / 4)  # [rad] yaw of the destination in the state beside it
_SIDES = np.arange(8) * math.pi / 4  # [rad]
_FINGER = 0.003  # [m] half the size of the finger that touches an object
_PRESSED = 2e-4  # [m] depth of its contact


class _Finger(MonitoredEntity):
    """A robot that consists of a finger, a cube that does not move."""

    def _build(self) -> None:
        self._mjcf_root = mjcf.RootElement(model="contract_finger")
        self._mjcf_root.worldbody.add("geom", type="box", size=(_FINGER,) * 3)

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """The model."""
        return self._mjcf_root


@dataclass(frozen=True)
class _Judged:
    """A condition in the situation of its example, with the cell and the tree of it alone."""

    cell: Cell
    tree: Tree
    condition: Any

    @classmethod
    def of(cls, case: BehaviourCase, **ports: Any) -> Self:
        """Restore the example's situation, and bind a new condition."""
        station = case.start()
        trial = case.trial(station, **ports)
        return cls(station.cell, trial.tree, trial.behaviour)

    @property
    def names(self) -> tuple[str, str]:
        """Names of the object and of its destination."""
        return self.condition.object, self.condition.read_port(self.condition.destination)

    def check_fails(self, state: str) -> None:
        """Check that the condition fails with a reason; `state` completes the message."""
        self.condition.begin_cycle()
        status, name = self.tree.tick(), type(self.condition).__name__
        assert status is NodeStatus.FAILURE, f"{name} holds although the object {state}"
        assert self.condition.feedback_message, f"{name} fails without a reason"

    def put(self, position: np.ndarray, *, steps: int = _SETTLING) -> None:
        """Move the object to a position [m], and make control steps."""
        name = self.names[0]
        T_wo = pin.SE3(self.cell.pose(name).rotation, position)
        self.cell.move(name, T_wo, overlap=math.inf)
        self.cell.step(steps)

    def put_beside(self, angle: float, yaw: float, *, gap: float, on_top: bool) -> None:
        """Put the object at a side of its destination's bounding box, and let it settle.

        Args:
            angle: Direction of the side in the destination's frame [rad].
            yaw: Angle by which the destination is turned first [rad].
            gap: Distance of the object's centre from the bounding box [m].
            on_top: Whether it is put on the edge of the top, instead of beside the bottom.
        """
        name, destination = self.names
        T_wd = self.cell.pose(destination)
        lower, upper = extent(self.cell, destination, T_wd)
        T_wd = T_wd * pin.SE3(pin.utils.rotate("z", yaw), np.zeros(3))
        self.cell.move(destination, T_wd, overlap=math.inf)
        side, local = np.array([math.cos(angle), math.sin(angle)]), 0.5 * (lower + upper)
        half = 0.5 * (upper - lower)[:2] + gap
        local[:2] += side * (half / np.maximum(np.abs(side), 1e-9)).min()
        local[2] = upper[2] if on_top else lower[2]
        height = np.ptp(extent(self.cell, name), axis=0)[2]
        self.put(T_wd.act(local) + np.array([0.0, 0.0, 0.5 * height + 1e-3]))


def fails_for_objects_far_away(case: BehaviourCase) -> None:
    """Check that it fails for an object at rest on a post far from everything."""
    judged = _Judged.of(case)
    name, destination = judged.names
    position = judged.cell.pose(destination).translation + _FAR
    below = judged.cell.pose(name).translation[2] - extent(judged.cell, name)[0][2]
    post = spatial.pose(position - np.array([0.0, 0.0, below + 0.01]))
    judged.cell.add(Box(size=(0.02, 0.02, 0.02)), post, name="contract_post", free=False)
    judged.put(position)
    judged.check_fails("is far away")


def fails_for_objects_that_vanished(case: BehaviourCase) -> None:
    """Check that it fails once the object or the destination has been removed."""
    for which in range(2):
        judged = _Judged.of(case)
        judged.cell.remove(judged.names[which])
        judged.check_fails("or its destination has vanished")


def fails_for_falling_objects(case: BehaviourCase) -> None:
    """Check that it fails for an object that falls on or into its destination."""
    for height in (0.0, 0.1, 0.3):
        judged = _Judged.of(case)
        name, destination = judged.names
        position = judged.cell.pose(destination).translation.copy()
        position[2] = extent(judged.cell, destination)[1][2] + height
        judged.put(position, steps=0)
        dof = judged.cell.model.body_dofadr[judged.cell.body_id(name)]
        judged.cell.data.qvel[dof + 2] = -1.0
        judged.cell.step(5)
        judged.check_fails("is falling")


def fails_for_held_objects(case: BehaviourCase) -> None:
    """Check that it fails on or in its destination, where it held, once a robot touches it."""
    for on_top in (True, False):
        judged = _Judged.of(case)
        name, destination = judged.names
        lower, upper = extent(judged.cell, destination)
        below = judged.cell.pose(name).translation - extent(judged.cell, name)[0]
        position = 0.5 * (lower + upper)
        position[2] = (upper if on_top else lower)[2] + below[2] + _RIM
        judged.put(position)
        if judged.tree.tick() is not NodeStatus.SUCCESS:
            continue
        lower, upper = extent(judged.cell, name)
        top = np.array([*0.5 * (lower + upper)[:2], upper[2] + _FINGER - _PRESSED])
        judged.cell.add(_Finger(), spatial.pose(top), name="contract_finger", free=False)
        judged.cell.step(20)
        judged.check_fails("is held")


def fails_on_containers_upside_down(case: BehaviourCase) -> None:
    """Check that it fails for an object at rest on a container that is upside down."""
    judged = _Judged.of(case)
    if judged.condition.destination != "container":
        return
    name, destination = judged.names
    turned = judged.cell.pose(destination) * pin.SE3(pin.utils.rotate("x", math.pi), np.zeros(3))
    height = np.ptp(extent(judged.cell, destination), axis=0)[2]
    turned.translation[2] += height + _PRESSED
    judged.cell.move(destination, turned, overlap=math.inf)
    lower, upper = extent(judged.cell, destination)
    below = judged.cell.pose(name).translation - extent(judged.cell, name)[0]
    judged.put(np.array([*0.5 * (lower + upper)[:2], upper[2] + below[2] + _PRESSED]))
    judged.check_fails("is on the bottom of its destination, which is upside down")


def fails_beside_turned_destinations(case: BehaviourCase) -> None:
    """Check that it fails for an object at rest beside its destination, turned or not."""
    for yaw in _TURNED:
        for angle in _SIDES:
            judged = _Judged.of(case)
            size = np.ptp(extent(judged.cell, judged.names[0]), axis=0)
            gap = 0.5 * float(np.linalg.norm(size[:2])) + _CLEAR
            judged.put_beside(angle, yaw, gap=gap, on_top=False)
            judged.check_fails(f"is beside its destination, turned by {yaw:.2f} rad")


def fails_for_swapped_objects(case: BehaviourCase) -> None:
    """Check that it fails with the names of object and destination exchanged."""
    judged = _Judged.of(case)
    name, destination = judged.names
    swapped = {"object": destination, judged.condition.destination: name}
    _Judged.of(case, **swapped).check_fails("and its destination are swapped")


def fails_on_the_rim(case: BehaviourCase) -> None:
    """Check that it fails for an object on the rim of a container or socket."""
    for angle in _SIDES:
        judged = _Judged.of(case)
        if judged.condition.destination not in ("container", "socket"):
            return
        judged.put_beside(angle, 0.0, gap=0.0, on_top=True)
        name, destination = judged.names
        if extent(judged.cell, name)[0][2] > extent(judged.cell, destination)[1][2] - _RIM:
            judged.check_fails("is on the rim")


def forgets_earlier_cycles(case: BehaviourCase) -> None:
    """Check that a condition that was evaluated begins a cycle like a new one."""
    used = _Judged.of(case)
    for _ in range(5):
        used.tree.tick()
        used.cell.step(10)
    new = _Judged.of(case)
    for one in (used, new):
        one.condition.begin_cycle()
    assert used.condition.get_state() == new.condition.get_state(), (
        f"{case.cls.__name__} keeps {used.condition.get_state()} from earlier cycles"
    )


CONDITION_CONTRACT: tuple[Callable[[BehaviourCase], None], ...] = (
    fails_for_objects_far_away, fails_for_objects_that_vanished, fails_for_falling_objects,
    fails_for_held_objects, fails_beside_turned_destinations, fails_for_swapped_objects,
    fails_on_the_rim, fails_on_containers_upside_down,
)  # fmt: skip
"""Checks of conditions on an object with a destination; each raises `AssertionError`."""
