"""Recorder of the trace of a run."""

from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError
from bt_manip.recording.step_log import StepLog
from bt_manip.recording.trace import Trace, columns_of
from bt_manip.runner import RunObserver


class TraceRecorder(RunObserver):
    """Write t, q, v, q_ref, v_ref, a_ref and tau of every control step to an .npz file."""

    def __init__(self, path: Path | None) -> None:
        """Check the path.

        Args:
            path: The file to write.

        Raises:
            BtManipError: When there is no path, or the file cannot be written.
        """
        if path is None:
            raise BtManipError("a trace needs a file to be written to: --record trace=FILE.npz")
        self._trace = Trace(path)
        self._logs: dict[str, StepLog] = {}

    def run_started(self, run: Any) -> None:
        """Bind to the station."""
        station = run.station
        self._logs = {name: StepLog(station.cell, one) for name, one in station.robots.items()}

    def after_compile(self) -> None:
        """Bind to the new model."""
        self._flush()
        for log in self._logs.values():
            log.bind()

    def after_step(self) -> None:
        """Copy the state after one control step."""
        full = False
        for log in self._logs.values():
            full = log.append()
        if full:
            self._flush()

    def run_ended(self) -> None:
        """Write the file."""
        self._flush()
        self._trace.close()

    def _flush(self) -> None:
        blocks = {name: log.take() for name, log in self._logs.items()}
        first = next(iter(blocks.values()), None)
        if first is not None and first.touches:
            self._trace.append(first.t, *columns_of(blocks))
