"""Where control steps are executed: in the simulation, or by a real robot."""

from collections.abc import Callable, Sequence
from typing import Any

from bt_manip.cell import Cell


class Hardware:
    """Executes control steps: this one simulates them, a `RealRobot` follows a robot.

    Args:
        cell: The cell.

    Attributes:
        simulated: Whether steps are simulated; those of a real robot take its own time.
        report: What a report says about it, as plain data; empty in simulation.
        speeds: How fast a real robot moves at most, for users; empty in simulation.
    """

    simulated = True
    report: dict[str, Any] = {}
    speeds = ""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell

    def step(self, steps: int, then: Sequence[Callable[[], None]] = ()) -> None:
        """Make control steps.

        Args:
            steps: Their number.
            then: Called after each step.
        """
        self.cell.step(steps, then=then)

    def close(self) -> None:
        """Let a real robot go, once it is at rest."""
