"""Reasons why grasp candidates were rejected."""

from collections import Counter
from collections.abc import Collection

from bt_manip.exceptions import MotionError


class Rejections:
    """Counts why grasps of one object were rejected, for the message when none is feasible.

    Attributes:
        approaches: Number of straight approaches that were not feasible.
    """

    def __init__(self, name: str, robots: Collection[str] = ()) -> None:
        """Start without rejections.

        Args:
            name: The object.
            robots: Names of the robots: obstacles that may move away.
        """
        self._name, self._robots = name, robots
        self._blocking_robot = ""
        self._no_clearance: Counter[str] = Counter()  # by entity, that of the best grasp first
        self._collisions: Counter[str] = Counter()
        self._approach_error: MotionError | None = None  # the first
        self._self_obstructed = self._unreachable = self.approaches = 0

    def no_clearance(self, entity: str) -> None:
        """Count a grasp at which an entity leaves the gripper no clearance."""
        self._no_clearance[entity] += 1

    def self_obstructed(self) -> None:
        """Count a grasp that another part of the object obstructs."""
        self._self_obstructed += 1

    def unreachable(self, count: int) -> None:
        """Count grasps that the arm cannot reach."""
        self._unreachable += count

    def collision(self, entity: str) -> None:
        """Count a grasp at which the arm or the lifted object would collide with an entity."""
        self._collisions[entity] += 1
        if entity in self._robots:
            self._blocking_robot = self._blocking_robot or entity

    def no_approach(self, error: MotionError | None) -> None:
        """Count a straight approach that cannot be followed or is blocked."""
        self.approaches += 1
        self._approach_error = self._approach_error or error

    @property
    def total(self) -> int:
        """Number of rejected grasps."""
        counted = self._no_clearance.total() + self._collisions.total()
        return counted + self._self_obstructed + self._unreachable + self.approaches

    def error(self) -> MotionError:
        """Return the error that says why no grasp is feasible."""
        name, error = self._name, self._approach_error
        if error is not None and error.reason == "robot":
            return error
        if self._blocking_robot:
            return MotionError(f"'{self._blocking_robot}' blocks '{name}'", reason="robot")
        reasons = []
        if self._no_clearance:
            first, *others = self._no_clearance
            reasons.append(f"'{first}' leaves the gripper no clearance at '{name}'")
            if others:
                reasons.append(f"'{others[0]}' leaves none at other grasps")
        if self._self_obstructed:
            reasons.append(f"other parts of '{name}' obstruct {self._self_obstructed} grasps")
        if self._collisions:
            entities = " and ".join(repr(entity) for entity in self._collisions)
            reasons.append(f"the arm would collide with {entities}")
        if self.approaches:
            reasons.append(f"{self.approaches} straight approaches are not feasible ({error})")
        tried = bool(reasons)
        if self._unreachable:
            reasons.append(f"{self._unreachable} grasps are unreachable")
        return MotionError(
            f"no feasible grasp of '{name}': {'; '.join(reasons) or 'there are no candidates'}",
            reason="grasp" if tried else "unreachable",
        )
