"""Trace of a run: every control step, as a file."""

import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.recording.files import check_writable, whole_file
from bt_manip.recording.step_log import StepBlock, StepLog
from bt_manip.runner import RunObserver

COLUMNS = ("q", "v", "q_ref", "v_ref", "a_ref", "tau")
"""Traced quantities beside the time; `q_ref`, `v_ref` and `a_ref` are the arm's reference."""


def columns_of(blocks: Mapping[str, StepBlock]) -> tuple[list[np.ndarray], list[str]]:
    """Return the traced columns of robots and their names; with several, ``robot/column``.

    Args:
        blocks: The same control steps of each robot, by its name.
    """
    prefixes = {name: f"{name}/" if len(blocks) > 1 else "" for name in blocks}
    columns = [getattr(block, column) for block in blocks.values() for column in COLUMNS]
    return columns, [prefix + column for prefix in prefixes.values() for column in COLUMNS]


class Trace:
    """Writes t, q, v, q_ref, v_ref, a_ref and tau of every control step to an ``.npz`` file.

    With several robots in a cell the file has ``left/q`` and so on, by their names.

    The rows are buffered in a temporary file, not in memory. The requested file is written
    atomically at the end.
    """

    def __init__(self, path: Path) -> None:
        """Check the path and open the temporary file.

        Args:
            path: The file to write.

        Raises:
            BtManipError: When the file cannot be written.
        """
        check_writable(path, "trace")
        self.path = path
        self._names: tuple[str, ...] = COLUMNS
        self._widths = (0,) * len(COLUMNS)
        self._rows = 0
        self._file: BinaryIO = tempfile.TemporaryFile()  # noqa: SIM115 (closed in close())

    def append(
        self, t: np.ndarray, columns: Sequence[np.ndarray], names: Sequence[str] = COLUMNS
    ) -> None:
        """Add control steps.

        Args:
            t: Simulated times [s].  # (n,)
            columns: As many as names, each of them (n, nq).
            names: Their names, the same at each call.
        """
        self._names, self._widths = tuple(names), tuple(column.shape[1] for column in columns)
        rows = np.column_stack((t, *columns))
        self._rows += len(rows)
        self._file.write(rows.tobytes())

    def close(self) -> None:
        """Write the file and delete the temporary one.

        Raises:
            OSError: When it cannot be written.
        """
        try:
            self._file.flush()
            width = 1 + sum(self._widths)
            table = (
                np.memmap(self._file, dtype=float, mode="r", shape=(self._rows, width))
                if self._rows
                else np.empty((0, width))
            )
            with whole_file(self.path) as target, zipfile.ZipFile(target, "w") as archive:
                _write(archive, "t", table[:, 0])
                first = 1
                for name, columns in zip(self._names, self._widths, strict=True):
                    _write(archive, name, table[:, first : first + columns])
                    first += columns
        finally:
            self._file.close()


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


def _write(archive: zipfile.ZipFile, name: str, column: np.ndarray) -> None:
    member = zipfile.ZipInfo(f"{name}.npy")  # without a time stamp: same run, same bytes
    with archive.open(member, "w", force_zip64=True) as file:
        np.lib.format.write_array(file, column)
