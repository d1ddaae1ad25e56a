"""The log of a run: its control steps and the digest of its states, kept once for all observers."""

import hashlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from .step_log import StepBlock, StepLog

if TYPE_CHECKING:
    from .run import Run

TakeBlocks = Callable[[Mapping[str, StepBlock]], None]


def next_digest(digest: bytes, state: bytes, statuses: bytes) -> bytes:
    """Return the SHA-256 digest of the previous digest, the state and the statuses.

    The state is MuJoCo's integration state, on which the next step depends. Two runs with the same
    digest have the same states, bit for bit.

    Args:
        digest: The digest after the previous tick; empty at the first.
        state: The integration state, as returned by `bt_manip.cell.Cell.state_bytes`.
        statuses: One byte for each node of the tree.
    """
    return hashlib.sha256(digest + state + statuses).digest()


class RunLog:
    """Control steps and digest of one execution of a run; each is kept from when it is asked for.

    Observers ask in `RunObserver.run_started`. Steps are copied once, however many observers read
    them, and handed over in blocks: before the model changes, at both ends of a cycle, at the end,
    and whenever a block is full.
    """

    def __init__(self, run: "Run") -> None:
        self._tree, self._cell = run.tree, run.station.cell
        self._robots = run.station.robots
        self._steps: dict[str, StepLog] = {}
        self._readers: list[TakeBlocks] = []
        self._digest: bytes | None = None

    # Observers

    def steps(self, read: TakeBlocks | None = None) -> Mapping[str, StepLog]:
        """Keep the control steps, of which each block is read; return their logs by robot."""
        if not self._steps:
            self._steps = {n: StepLog(self._cell, robot) for n, robot in self._robots.items()}
        if read is not None:
            self._readers.append(read)
        return self._steps

    def keep_digest(self, digest: bytes = b"") -> None:
        """Keep the digest of the states after each tick, continuing one of an earlier run."""
        if self._digest is None or digest:
            self._digest = digest

    @property
    def digest(self) -> bytes:
        """The digest after the last tick; empty without one."""
        return self._digest or b""

    # The loop

    @property
    def after_step(self) -> tuple[Callable[[], None], ...]:
        """Functions to be called after each control step."""
        appends = [log.append for log in self._steps.values()]

        def copy() -> None:
            full = False
            for append in appends:
                full |= append()
            if full:
                self.flush()

        return (copy,) if appends else ()

    def after_compile(self) -> None:
        """Bind to the new model."""
        for log in self._steps.values():
            log.bind()

    def after_tick(self) -> None:
        """Add the state to the digest."""
        if self._digest is not None:
            state, statuses = self._cell.state_bytes(), self._tree.statuses()
            self._digest = next_digest(self._digest, state, statuses)

    def flush(self) -> None:
        """Hand over the control steps since the last call."""
        blocks = {name: log.take() for name, log in self._steps.items()}
        if blocks and next(iter(blocks.values())).touches:
            for read in self._readers:
                read(blocks)
