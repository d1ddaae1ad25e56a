"""Phases of a cycle: the action leaves that ended."""

from collections.abc import Callable
from typing import Any

from bt_manip.bt.nodes import NodeKind
from bt_manip.recording.report import Phase


class PhaseLog:
    """Tree observer that records the action leaves, in the order in which they end."""

    def __init__(self, clock: Callable[[], float], ended: Callable[[Any, Phase], None]) -> None:
        """Initialise without phases.

        Args:
            clock: Returns the simulated time [s].
            ended: Called with node and phase when an action leaf has ended.
        """
        self._clock, self._ended = clock, ended
        self.begin()

    def begin(self) -> None:
        """Begin a cycle."""
        self._start = self._clock()
        self._running: dict[Any, float] = {}
        self._phases: list[Phase] = []

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Phases that have ended in this cycle."""
        return tuple(self._phases)

    def __call__(self, node: Any, old: Any, new: Any) -> None:
        """Record a change of a node's status."""
        if node.kind is not NodeKind.ACTION:
            return
        if new.name == "RUNNING":
            self._running.setdefault(node, self._clock())
        elif new.name in ("SUCCESS", "FAILURE"):
            self._end(node, new.name, self._running.pop(node, self._clock()))
        elif node in self._running:
            self._end(node, "HALTED", self._running.pop(node))

    def _end(self, node: Any, status: str, start: float) -> None:
        phase = Phase(
            behaviour=str(node.registration),
            name=str(node.name),
            status=status,
            reason="" if status == "SUCCESS" else str(node.feedback_message),
            start_s=_seconds(start - self._start),
            duration_s=_seconds(self._clock() - start),
        )
        self._phases.append(phase)
        self._ended(node, phase)


def _seconds(duration: float) -> float:
    """Round to microseconds: sums of control steps of 1 ms have rounding errors."""
    return round(duration, 6)
