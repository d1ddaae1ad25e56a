"""Stand-ins for leaves: trees are tested without what their leaves do."""

from collections.abc import Sequence

from bt_manip.bt import NodeStatus
from bt_manip.bt.nodes import TestNodeConfig
from bt_manip.exceptions import did_you_mean

Result = NodeStatus | str


def status_of(status: Result) -> NodeStatus:
    """Read the name of a status.

    Raises:
        ValueError: When it is none; the nearest names are offered.
    """
    if isinstance(status, NodeStatus):
        return status
    if status not in NodeStatus.__members__:
        raise ValueError(f"no status '{status}'{did_you_mean(status, NodeStatus.__members__)}")
    return NodeStatus[status]


class Stub:
    """What stands in for a leaf returns what a test says, and counts how often it did.

    Attributes:
        config: For `bt_manip.bt`'s substitution rules.
        calls: How often it has completed.
    """

    def __init__(
        self, *results: Result | Sequence[Result], after: float = 0.0, script: str = ""
    ) -> None:
        """Say what to return.

        Args:
            *results: What to return at the first completion, the second, ...; the last from then
                on. Nothing means ``SUCCESS``.
            after: Simulated time for which it is running before [s].
            script: Runs on success, to write what the leaf would have put out: ``"n := 3"``.
        """
        names = [r for result in results for r in ([result] if isinstance(result, str | NodeStatus)
                                                   else result)]  # fmt: skip
        self._results = [status_of(r) for r in names or ["SUCCESS"]]
        self.calls = 0
        self.config = TestNodeConfig(
            complete_func=self._complete, async_delay=round(1000 * after), success_script=script
        )

    def _complete(self) -> NodeStatus:
        result = self._results[min(self.calls, len(self._results) - 1)]
        self.calls += 1
        return result

    def __repr__(self) -> str:
        """Show what it returns."""
        return f"Stub({', '.join(result.name for result in self._results)})"
