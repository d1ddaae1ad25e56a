"""The course of the joints at 1 kHz, as a file."""

import tempfile
import zipfile
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

import numpy as np

from bt_manip.recording.files import check_writable, whole_file

COLUMNS = ("q", "v", "q_ref", "v_ref", "a_ref", "tau")
"""What is traced beside the time; `q_ref`, `v_ref` and `a_ref` are what the arm asked for."""


class Trace:
    """Keeps t, q, v, q_ref, v_ref, a_ref and tau of every control step for an ``.npz`` file.

    The rows wait in a temporary file, so that a run of any length needs no memory for them. The
    file that was asked for is written at the end, whole or not at all.
    """

    def __init__(self, path: Path) -> None:
        """Get ready to write.

        Args:
            path: The file to be.

        Raises:
            BtManipError: When the file cannot be written.
        """
        check_writable(path, "trace")
        self.path = path
        self._nq = 0
        self._rows = 0
        self._file: BinaryIO = tempfile.TemporaryFile()  # noqa: SIM115 (closed in close())

    def append(self, t: np.ndarray, columns: tuple[np.ndarray, ...]) -> None:
        """Add control steps.

        Args:
            t: Simulated times [s].  # (n,)
            columns: As in `COLUMNS`, each of them (n, nq).
        """
        self._nq = columns[0].shape[1]
        rows = np.column_stack((t, *columns))
        self._rows += len(rows)
        self._file.write(rows.tobytes())

    def close(self) -> None:
        """Write the file and let the temporary one go.

        Raises:
            OSError: When it cannot be written.
        """
        try:
            self._file.flush()
            width = 1 + len(COLUMNS) * self._nq
            table = (
                np.memmap(self._file, dtype=float, mode="r", shape=(self._rows, width))
                if self._rows
                else np.empty((0, width))
            )
            with whole_file(self.path) as target, zipfile.ZipFile(target, "w") as archive:
                _write(archive, "t", table[:, 0])
                for i, name in enumerate(COLUMNS):
                    _write(archive, name, table[:, 1 + i * self._nq : 1 + (i + 1) * self._nq])
        finally:
            self._file.close()

    def __enter__(self) -> "Trace":
        """Give the trace itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write what there is, also when something raised."""
        self.close()


def _write(archive: zipfile.ZipFile, name: str, column: np.ndarray) -> None:
    member = zipfile.ZipInfo(f"{name}.npy")  # without the time of day: same run, same bytes
    with archive.open(member, "w", force_zip64=True) as file:
        np.lib.format.write_array(file, column)
