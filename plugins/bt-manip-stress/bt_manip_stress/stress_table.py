"""The table of a stress test: phase by fault, and the reasons."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from bt_manip.exceptions import without_numbers

from .stress_test import TIMEOUT, Outcome, StressEpisode, StressResult

LETTERS: Final[dict[Outcome, str]] = {
    "recovered": "R",
    "failed": "F",
    "dishonest": "D",
    "hung": "H",
    "died": "X",
}
"""Letters of the outcomes in a cell of the table."""

NOT_TRIED = "?"
"""Letter of episodes that an interrupted test has not run."""

NEXT_FAILED = "N"
"""Letter of episodes after which the undisturbed cycle did not reach its goal."""

LEGEND = (
    "Each cell counts seeds. R: recovered (SUCCESS, and the goal holds). F: failed honestly. "
    "D: dishonest (SUCCESS, but the goal does not hold). "
    f"H: hung (no end within {TIMEOUT:g} s simulated). "
    "X: its process died. "
    "N: the undisturbed cycle after it failed. -: the fault cannot happen there."
)


@dataclass(frozen=True)
class StressTable:
    """The results of a stress test by fault and phase.

    Attributes:
        results: The results, in the order of their episodes.
        planned: All episodes, where the test was interrupted; empty: those of the results.
    """

    results: Sequence[StressResult]
    planned: Sequence[StressEpisode] = ()

    @property
    def episodes(self) -> Sequence[StressEpisode]:
        """All planned episodes, also the untried ones."""
        return self.planned or [one.episode for one in self.results]

    @property
    def phases(self) -> list[str]:
        """Names of the phases: the columns."""
        return list(dict.fromkeys(one.phase.name for one in self.episodes))

    @property
    def faults(self) -> list[str]:
        """Names of the faults: the rows."""
        return list(dict.fromkeys(one.fault for one in self.episodes))

    def rows(self) -> list[list[str]]:
        """Return a row for each fault: its name and a cell for each phase."""
        return [
            [fault, *(self._cell(fault, phase) for phase in self.phases)] for fault in self.faults
        ]

    def summary(self) -> str:
        """Return how many episodes ended how."""
        counts = Counter(one.outcome for one in self.results)
        happened = len(self.results) - counts["none"]
        shown = [outcome for outcome in LETTERS if outcome != "died" or counts[outcome]]
        text = ", ".join(f"{counts[outcome]} {outcome}" for outcome in shown)
        failed = sum(bool(one.next_reason) for one in self.results)
        left = len(self.episodes) - len(self.results)
        more = (
            f" {left} of {len(self.episodes)} episodes were not tried ({NOT_TRIED})."
            if left
            else ""
        )
        return f"{happened} faults: {text}; {failed} undisturbed cycles after them failed.{more}"

    def reasons(self) -> list[str]:
        """Return why faults were not recovered from, each reason once for each fault.

        Reasons that differ in numbers only are one.
        """
        found: dict[tuple[str, str, str], tuple[str, Counter[str]]] = {}
        for one in self.results:
            letter = LETTERS.get(one.outcome, "")
            reasons = [(letter, one.reason)] if letter not in ("", "R") else []
            if one.next_reason:
                reasons.append((NEXT_FAILED, one.next_reason))
            for letter, reason in reasons:
                key = one.episode.fault, letter, without_numbers(reason)
                _, phases = found.setdefault(key, (reason, Counter()))
                phases[one.episode.phase.name] += 1
        lines = []
        for (fault, letter, _), (reason, phases) in found.items():
            where = ", ".join(f"{phase} {count}" for phase, count in phases.items())
            lines.append(f"{fault} {letter} ({where}): {reason}")
        return lines

    def markdown(self, command: str) -> str:
        """Return the table and the reasons as Markdown; faults that cannot happen have no row.

        Args:
            command: The command that made it.
        """
        lines = [f"Made by `{command}`.", "", f"{self.summary()} {LEGEND}", ""]
        header, rows = ["fault", *self.phases], self.rows()
        happen = [row for row in rows if set(row[1:]) != {"-"}]
        for row in (header, ["---"] * len(header), *happen):
            lines.append(f"| {' | '.join(row)} |")
        if never := [row[0] for row in rows if row not in happen]:
            lines += ["", f"Cannot happen in this tree: {', '.join(never)}."]
        lines += ["", *(f"- {reason.replace('|', '/')}" for reason in self.reasons())]
        return "\n".join(lines).rstrip() + "\n"

    def plain(self) -> list[dict[str, object]]:
        """Return the results as plain data for JSON."""
        return [
            {
                "fault": one.episode.fault,
                "phase": one.episode.phase.name,
                "seed": one.episode.seed,
                "planned": str(one.episode.plan()),
                "outcome": one.outcome,
                "reason": one.reason,
                "next_reason": one.next_reason,
            }
            for one in self.results
        ]

    def _cell(self, fault: str, phase: str) -> str:
        here = [
            one
            for one in self.results
            if (one.episode.fault, one.episode.phase.name) == (fault, phase)
        ]
        counts = Counter(one.outcome for one in here)
        parts = [f"{letter}{counts[o]}" for o, letter in LETTERS.items() if counts[o]]
        failed = sum(bool(one.next_reason) for one in here)
        parts += [f"{NEXT_FAILED}{failed}"] * bool(failed)
        if here and not parts:
            parts = ["-"]
        planned = sum((one.fault, one.phase.name) == (fault, phase) for one in self.episodes)
        return " ".join(parts + [f"{NOT_TRIED}{planned - len(here)}"] * (planned > len(here)))
