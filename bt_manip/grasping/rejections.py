"""Reasons why grasp candidates were rejected."""

from collections import Counter
from collections.abc import Collection

from bt_manip.cell import entity_of
from bt_manip.exceptions import MotionError


class Rejections:
    """Counts rejected grasps of one object by reason, for the error if none is feasible.

    Args:
        name: The object.
        robots: Names of the other robots: obstacles that may move away.

    Attributes:
        no_clearance: Grasps without clearance of the gripper, by entity.
        collisions: Grasps with a collision of the arm or the lifted object, by pair of bodies, the
            body of the arm or the object first.
        self_obstructed: Grasps obstructed by another part of the object.
        approaches: Infeasible or blocked straight approaches.
        unreachable: Unreachable grasps.
    """

    def __init__(self, name: str, robots: Collection[str] = ()) -> None:
        self._name, self._robots = name, robots
        self.no_clearance: Counter[str] = Counter()  # the entity at the best grasp first
        self.collisions: Counter[tuple[str, str]] = Counter()
        self.self_obstructed = self.approaches = self.unreachable = 0
        self._approach_error: MotionError | None = None  # the first

    def reject_approach(self, error: MotionError | None) -> None:
        """Count a straight approach, and store the first error."""
        self.approaches += 1
        self._approach_error = self._approach_error or error

    @property
    def total(self) -> int:
        """Number of rejected grasps."""
        by_entity = self.no_clearance.total() + self.collisions.total()
        return by_entity + self.self_obstructed + self.approaches + self.unreachable

    def error(self) -> MotionError:
        """Return the error with the reasons why no grasp is feasible."""
        name, error = self._name, self._approach_error
        if error is not None and error.reason == "robot":
            return error
        for _, other in self.collisions:
            robot = entity_of(other)
            if robot in self._robots:
                return MotionError(f"'{robot}' blocks '{name}'", reason="robot")
        reasons = []
        if self.no_clearance:
            first, *others = self.no_clearance
            reasons.append(f"'{first}' leaves the gripper no clearance at '{name}'")
            reasons += [f"'{other}' leaves none at other grasps" for other in others[:1]]
        if self.self_obstructed:
            reasons.append(f"other parts of '{name}' obstruct {self.self_obstructed} grasps")
        if self.collisions:
            pairs = [f"'{first}' would touch '{second}'" for first, second in self.collisions]
            reasons += pairs[:2]
        if self.approaches:
            reasons.append(f"{self.approaches} straight approaches are not feasible ({error})")
        reason = "grasp" if reasons else "unreachable"
        if self.unreachable:
            reasons.append(f"{self.unreachable} grasps are unreachable")
        listed = "; ".join(reasons) or "there are no candidates"
        return MotionError(f"no feasible grasp of '{name}': {listed}", reason=reason)
