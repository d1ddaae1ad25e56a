"""What the moves to a target of one's own have in common."""

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
        """Refuse a tolerance that nothing could be within, too."""
        super().check_amounts()
        check_positive(self.tolerance, "port 'tolerance'", "rad")

    @property
    def largest_error(self) -> float:
        """Error of a joint up to which the arm has arrived [rad]."""
        return float(self.tolerance)


class PlannedMove(Move):
    """A motion around what is in the way."""

    planner = Input(str, default="", doc="Registered planner; by default that of the run.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the planners and the randomness that they draw from, too."""
        super().setup(**infrastructure)
        self._rng = infrastructure["rng"]
        self._planners = infrastructure["planners"]

    def planning(self) -> dict[str, Any]:
        """Give what the arm plans with.

        Raises:
            UnknownPartError: When the planner is not registered.
        """
        name = self.planner
        planner: Planner | None = self._planners.create(name) if name else None
        return {"planner": planner, "rng": self._rng}
