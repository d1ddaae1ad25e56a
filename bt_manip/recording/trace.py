"""Trace of a run: every control step, as a file."""

import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

import numpy as np

from bt_manip.recording.files import check_writable, whole_file
from bt_manip.recording.step_log import StepBlock

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

    def __enter__(self) -> "Trace":
        """Return the trace."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write the file, also after an exception."""
        self.close()


def _write(archive: zipfile.ZipFile, name: str, column: np.ndarray) -> None:
    member = zipfile.ZipInfo(f"{name}.npy")  # without a time stamp: same run, same bytes
    with archive.open(member, "w", force_zip64=True) as file:
        np.lib.format.write_array(file, column)
