"""Stubs for leaves of trees under test."""

from collections.abc import Sequence

from bt_manip.bt import NodeStatus
from bt_manip.bt.nodes import TestNodeConfig
from bt_manip.exceptions import did_you_mean

Result = NodeStatus | str


def status_of(status: Result) -> NodeStatus:
    """Return the status of a name; a ValueError suggests the nearest."""
    if isinstance(status, NodeStatus):
        return status
    if status not in NodeStatus.__members__:
        raise ValueError(f"no status '{status}'{did_you_mean(status, NodeStatus.__members__)}")
    return NodeStatus[status]


class Stub:
    """Stub for a leaf: returns given results and counts its completions.

    Args:
        *results: Results of the first completion, the second, ...; the last one is repeated.
            Default: ``SUCCESS``.
        after: Simulated time before each result [s].
        script: Script run on success, to write the outputs of the leaf: ``"n := 3"``.

    Attributes:
        config: Configuration for the substitution rules of `bt_manip.bt`.
        calls: Number of completions.
    """

    def __init__(
        self, *results: Result | Sequence[Result], after: float = 0.0, script: str = ""
    ) -> None:
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
