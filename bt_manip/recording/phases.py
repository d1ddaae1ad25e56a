"""The action leaves of a cycle, in the order in which they ended."""

from collections.abc import Callable
from typing import Any

from bt_manip.bt.nodes import NodeKind
from bt_manip.recording.report import Phase


class PhaseLog:
    """Watches a tree's nodes and keeps what its action leaves did."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """Begin with nothing.

        Args:
            clock: Gives the simulated time [s].
        """
        self._clock = clock
        self.ended: list[Callable[[Any, Phase], None]] = []
        """Called with the node and its phase when an action leaf has ended."""
        self.begin()

    def begin(self) -> None:
        """Begin a cycle."""
        self._start = self._clock()
        self._running: dict[Any, float] = {}
        self._phases: list[Phase] = []

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Give the phases that have ended in this cycle."""
        return tuple(self._phases)

    def __call__(self, node: Any, old: Any, new: Any) -> None:
        """Note that a node has another status."""
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
        for listener in self.ended:
            listener(node, phase)


def _seconds(duration: float) -> float:
    """Round away what adding up control steps of 1 ms leaves behind the microsecond."""
    return round(duration, 6)
