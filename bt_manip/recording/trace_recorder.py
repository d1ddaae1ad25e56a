"""The trace of a run as a recorder of its own."""

from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError
from bt_manip.recording.step_log import StepLog
from bt_manip.recording.trace import Trace
from bt_manip.runner.observer import RunObserver


class TraceRecorder(RunObserver):
    """Write t, q, v, q_ref, v_ref, a_ref and tau of every control step to an .npz file."""

    def __init__(self, path: Path | None) -> None:
        """Get ready to write.

        Args:
            path: The file to be.

        Raises:
            BtManipError: When there is no path, or the file cannot be written.
        """
        if path is None:
            raise BtManipError("a trace needs a file to be written to: --record trace=FILE.npz")
        self._trace = Trace(path)
        self._log: StepLog | None = None

    def run_started(self, run: Any) -> None:
        """Look at the station."""
        self._log = StepLog(run.station)

    def model_changed(self) -> None:
        """Bind to the new model."""
        if self._log is not None:
            self._flush(self._log)
            self._log.bind()

    def after_step(self) -> None:
        """Copy the state after one control step."""
        if self._log is not None and self._log.append():
            self._flush(self._log)

    def run_ended(self) -> None:
        """Write the file."""
        if self._log is not None:
            self._flush(self._log)
        self._trace.close()

    def _flush(self, log: StepLog) -> None:
        block = log.take()
        if block.touches:
            columns = (block.q, block.v, block.q_ref, block.v_ref, block.a_ref, block.tau)
            self._trace.append(block.t, columns)
