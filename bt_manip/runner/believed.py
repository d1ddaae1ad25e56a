"""What a tree believes, where it does not know the physics."""

import abc
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from dm_control import composer

from bt_manip.cell import Cell
from bt_manip.scenes import ExpectedObjects

from .commanded_robot import CommandedRobot
from .hardware import Hardware


class Believed(abc.ABC):
    """A second cell of the scene, which trees get in place of that of the physics.

    The physics has controllers, faults, recorders and the judge of the goal; the tree has the
    believed cell with twins of the robots, whose arms the controllers in the physics follow. It is
    made by `PoseSource.believed_cell` with the keyword arguments ``scene``, with the objects that
    are expected; ``chosen``, its `SceneRobot` s; ``cell`` and ``robots`` of the physics;
    ``source``, ``parts``, ``catalogue`` and ``seed``.

    Attributes:
        cell: The believed cell.
        robots: The twins by name, each with the controllers in the physics.
        poses: The expected objects, which are absent until they are reported.
    """

    cell: Cell
    robots: Mapping[str, CommandedRobot]
    poses: ExpectedObjects

    @abc.abstractmethod
    def begin(self) -> None:
        """Begin a cycle, after the physics was randomized."""

    @abc.abstractmethod
    def measure(self) -> None:
        """Take the measurements of a control step of the physics."""

    @abc.abstractmethod
    def follow(self, steps: int) -> None:
        """Follow the physics after some control steps, at its time."""

    @abc.abstractmethod
    def get_state(self) -> dict[str, Any]:
        """Return its state besides those of the arms, as plain data."""

    @abc.abstractmethod
    def set_state(
        self, state: Mapping[str, Any], make: Callable[[Mapping[str, Any]], composer.Entity]
    ) -> None:
        """Restore a state of `get_state`, at the present time of the physics.

        Args:
            state: The state.
            make: Makes an object of its cell's snapshot.
        """


class BelievedHardware(Hardware):
    """Simulates control steps, which a believed cell follows."""

    def __init__(self, cell: Cell, believed: Believed) -> None:
        super().__init__(cell)
        self._believed = believed

    def step(self, steps: int, then: Sequence[Callable[[], None]] = ()) -> None:
        """Make control steps in the physics, then let the believed cell follow."""
        super().step(steps, (self._believed.measure, *then))
        self._believed.follow(steps)
