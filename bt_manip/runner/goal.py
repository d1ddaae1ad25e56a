"""Judging the goal of a tree, cycle by cycle, from the physics."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bt_manip.bt import Tree, texts_of, why_not_met
from bt_manip.bt.nodes import Condition
from bt_manip.cell import Cell, why_not_released

NOT_MET = "goal not met: "


@dataclass
class Gripped:
    """An object that was gripped; `placed` counts once it is removed."""

    name: str
    robot: str = ""
    removed: bool = False
    placed: bool | None = None


class GoalJudge:
    """Judges the goal of a tree in each cycle; the run has the same states with and without it.

    A condition that names an object is judged in the step before that object is removed, and that
    result counts. It is judged again if there is an object of that name again. All others are
    judged at the end of the cycle.

    Attributes:
        holds: Whether the goal held in the last cycle; None if the tree declares none.
        reason: Why it did not hold; empty otherwise.
        gripped: The objects that were gripped in this cycle, as somebody has told, in their order.
    """

    def __init__(self, tree: Tree, cell: Cell) -> None:
        self._tree, self._cell = tree, cell
        self._goal = tree.goal
        self._kept: list[list[str]] = []
        self._names: list[set[str]] = []
        self._cycle: int | None = None
        self.holds: bool | None = None
        self.reason = ""
        self.gripped: list[Gripped] = []
        self._clear()

    def begin(self, cycle: int = 0) -> None:
        """Begin a cycle, or continue the one of the restored state."""
        self._follow_tree()
        if cycle != self._cycle:
            self._clear()
            self.gripped = []
            for condition in self._goal:
                if isinstance(condition, Condition):
                    condition.begin_cycle()
        self._cycle = cycle
        if self._judge_before not in self._cell.before_remove:
            self._cell.before_remove.append(self._judge_before)

    def end(self, succeeded: bool, reason: str) -> tuple[bool, str]:
        """End a cycle that the tree ended so; return whether it succeeded, and why not."""
        self.stop()
        self.reason = self.why_not()
        self.holds = not self.reason if self._goal else None
        if succeeded and self.holds is False:
            return False, NOT_MET + self.reason
        return succeeded, reason

    def why_not(self) -> str:
        """Return why the goal does not hold now; empty if it does, or the tree declares none."""
        return "; ".join(dict.fromkeys(filter(None, self.reasons())))

    def reasons(self) -> list[str]:
        """Return why each condition of the goal does not hold now; empty texts where it does."""
        self._follow_tree()
        found = []
        for i, condition in enumerate(self._goal):
            reasons = list(self._kept[i])
            if not self._is_judged(i):
                reasons.append(why_not_met(condition))
            found.append("; ".join(dict.fromkeys(filter(None, reasons))))
        return found

    def placed(self, name: str) -> bool | None:
        """Return whether an object lies where it was to be: released, at rest, at its destination.

        All conditions with a `destination` that name it hold. None if there is none.
        """
        self._follow_tree()
        about = [
            condition
            for condition in self._goal
            if getattr(condition, "destination", "") and name in texts_of(condition)
        ]
        if not about or name not in self._cell.entities:
            return False if about else None
        return not (why_not_released(self._cell, name) or any(map(why_not_met, about)))

    def grip(self, name: str, robot: str) -> None:
        """Remember that an object is gripped, until it is removed."""
        for one in self.gripped:
            if one.name == name and not one.removed:
                one.robot = robot
                return
        self.gripped.append(Gripped(name, robot))

    def stop(self) -> None:
        """Stop observing the cell."""
        self._cycle = None
        if self._judge_before in self._cell.before_remove:
            self._cell.before_remove.remove(self._judge_before)

    def get_state(self) -> dict[str, Any]:
        """Return the goal's verdict for this cycle and the state of its conditions."""
        return {
            "cycle": self._cycle,
            "kept": [list(kept) for kept in self._kept],
            "names": list(map(sorted, self._names)),
            "conditions": [condition.get_state() for condition in self._goal],
            "gripped": [dict(vars(one)) for one in self.gripped],
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of `get_state`; the cycle that begins next continues with it."""
        self._cycle = state["cycle"]
        self._kept = [list(kept) for kept in state["kept"]]
        self._names = [set(names) for names in state["names"]]
        for condition, remembered in zip(self._goal, state.get("conditions", ()), strict=False):
            condition.set_state(remembered)
        self.gripped = [Gripped(**one) for one in state.get("gripped", ())]

    def _clear(self) -> None:
        self._kept = [[] for _ in self._goal]
        self._names = [set() for _ in self._goal]

    def _follow_tree(self) -> None:
        """Judge the goal of the tree that replaced the one before."""
        if self._goal is not self._tree.goal:
            self._goal = self._tree.goal
            self._clear()

    def _is_judged(self, i: int) -> bool:
        """Return whether the object of a condition was judged and has been removed."""
        removed = self._names[i] - self._cell.entities.keys()
        return bool(removed) and not removed.isdisjoint(texts_of(self._goal[i]))

    def _judge_before(self, name: str) -> None:
        """Judge an object that is about to be removed, and the conditions that name it."""
        self._follow_tree()
        for one in self.gripped:
            if one.name == name and not one.removed:
                one.removed, one.placed = True, self.placed(name)
        for i, condition in enumerate(self._goal):
            named = set(texts_of(condition))
            if name in named and not self._is_judged(i):
                self._kept[i].append(why_not_met(condition))
                self._names[i] = named & self._cell.entities.keys()
