"""Base classes of behaviours that move to a given target."""

from typing import Any

from bt_manip.bt import Input
from bt_manip.checks import check_positive
from bt_manip.planning import Planner

from .arm_behaviour import MotionBehaviour


class Move(MotionBehaviour):
    """A motion with a speed and a tolerance."""

    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")
    tolerance = Input(
        float, default=MotionBehaviour.ARRIVED, doc="Largest error of a joint on arrival [rad]."
    )

    def check_amounts(self) -> None:
        """Check the tolerance too."""
        super().check_amounts()
        check_positive(self.tolerance, "port 'tolerance'", "rad")

    @property
    def largest_error(self) -> float:
        """Largest joint error at which the arm has arrived [rad]."""
        return float(self.tolerance)


class PlannedMove(Move):
    """A motion around obstacles."""

    planner = Input(
        str, default="", doc="Name of a registered planner; by default that of the run."
    )

    def setup(self, **infrastructure: Any) -> None:
        """Keep the planners and their random generator too."""
        super().setup(**infrastructure)
        self._rng = infrastructure["rng"]
        self._planners = infrastructure["planners"]

    def planning(self) -> dict[str, Any]:
        """Return the planner and the random generator.

        Raises:
            UnknownPartError: When the planner is not registered.
        """
        name = self.planner
        planner: Planner | None = self._planners.create(name) if name else None
        return {"planner": planner, "rng": self._rng}
