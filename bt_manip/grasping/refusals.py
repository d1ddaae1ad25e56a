"""What speaks against grasps that do not serve."""

from collections import Counter
from collections.abc import Collection

from bt_manip.exceptions import MotionError


class Refusals:
    """Counts why grasps of one object were refused, to tell it when none is left.

    Attributes:
        ways: Lines to the object that the tool cannot follow.
    """

    def __init__(self, name: str, robots: Collection[str] = ()) -> None:
        """Begin with none.

        Args:
            name: The object.
            robots: Names of the robots: what is in the way now and may go away by itself.
        """
        self._name, self._robots = name, robots
        self._robot = ""  # that was in the way
        self._taken: Counter[str] = Counter()  # in the order of the grasps, the best first
        self._blocked: Counter[str] = Counter()
        self._why: MotionError | None = None  # why there was no way, the first time
        self._itself = self._unreachable = self.ways = 0

    def no_room(self, by: str) -> None:
        """Note that something leaves the hand no room."""
        self._taken[by] += 1

    def in_itself(self) -> None:
        """Note that another part of the object is in the way of the hand."""
        self._itself += 1

    def unreachable(self, count: int) -> None:
        """Note that the arm reaches none of several."""
        self._unreachable += count

    def blocked(self, by: str) -> None:
        """Note that the arm would touch something."""
        self._blocked[by] += 1
        if by in self._robots:
            self._robot = self._robot or by

    def no_way(self, error: MotionError | None) -> None:
        """Note that the arm cannot go straight on, or that something is in the way there."""
        self.ways += 1
        self._why = self._why or error

    def count(self) -> str:
        """Say how many were refused, where there were any."""
        total = self._taken.total() + self._itself + self._unreachable + self._blocked.total()
        total += self.ways
        return f"; {total} refused before" if total else ""

    def error(self) -> MotionError:
        """Say why there is no grasp."""
        name, why = self._name, self._why
        if why is not None and why.reason == "robot":
            return why
        if self._robot:
            return MotionError(f"'{self._robot}' blocks '{name}'", reason="robot")
        parts = []
        if self._taken:
            first, *others = self._taken
            parts.append(f"'{first}' leaves the fingers no room at '{name}'")
            if others:
                parts.append(f"elsewhere '{others[0]}' leaves none")
        if self._itself:
            parts.append(f"other parts of '{name}' are in the way of {self._itself} grasps")
        if self._blocked:
            parts.append(f"the arm would touch {' and '.join(repr(n) for n in self._blocked)}")
        if self.ways:
            parts.append(f"from {self.ways} places the tool cannot go straight to it ({why})")
        if self._unreachable:
            parts.append(f"{self._unreachable} grasps are unreachable")
        tried = self._taken or self._itself or self._blocked or self.ways
        return MotionError(
            f"no grasp of '{name}' serves: {'; '.join(parts) or 'there is none'}",
            reason="grasp" if tried else "unreachable",
        )
