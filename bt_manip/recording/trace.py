"""Trace of a run: every control step, as a file."""

import io
import os
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.recording.files import (
    AppendedFile,
    RecordingError,
    check_writable,
    is_special,
    reading,
    whole_file,
)
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

    While the run goes on, the file is a structured array in NumPy's NPY format with the same names,
    which grows; `read_trace` and ``np.load`` read both. At the end it is replaced by the archive,
    which has the names of the joints, too: ``joints``.
    """

    def __init__(self, path: Path) -> None:
        """Check the path; the file is created with the first steps.

        Args:
            path: The file to write.

        Raises:
            BtManipError: When the file cannot be written.
        """
        check_writable(path, "trace")
        self.path = path
        # A pipe or a device cannot grow.
        self._buffer = tempfile.NamedTemporaryFile() if is_special(path) else None  # noqa: SIM115
        self._growing = Path(self._buffer.name if self._buffer else path)
        self._file: AppendedFile | None = None
        self._dtype = np.dtype([("t", float), *((name, float, (0,)) for name in COLUMNS)])
        self._rows = 0
        self._problem = ""
        self._joints: dict[str, list[str]] = {}  # by name in the archive

    def name_joints(self, station: Any) -> None:
        """Take over the names of the joints of the robots of a `bt_manip.runner.Station`."""
        robots = station.robots
        for name, one in robots.items():
            prefix = f"{name}/" if len(robots) > 1 else ""
            self._joints[f"{prefix}joints"] = list(one.robot.description.arm_joints)

    def append(
        self, t: np.ndarray, columns: Sequence[np.ndarray], names: Sequence[str] = COLUMNS
    ) -> None:
        """Add control steps; after a failure, which `close` raises, nothing is added.

        Args:
            t: Simulated times [s].  # (n,)
            columns: As many as names, each of them (n, nq).
            names: Their names, the same at each call.
        """
        if self._problem:
            return
        try:
            if self._file is None:
                widths = ((n, float, c.shape[1:]) for n, c in zip(names, columns, strict=True))
                self._dtype = np.dtype([("t", float), *widths])
                self._file = AppendedFile(self._growing)
                self._file.append(self._header())
            self._file.append(np.column_stack((t, *columns)).tobytes())
            self._rows += len(t)
            self._file.overwrite(self._header())
        except OSError as error:
            self._problem = (
                f"trace '{self.path}' cannot be written: {error.strerror}; the steps from "
                f"{t[0]:.3f} s on are lost"
            )

    def close(self) -> None:
        """Replace the file by the archive.

        Raises:
            RecordingError: When it cannot be written.
        """
        try:
            if self._file is not None:
                self._file.close()
            if not self._problem:
                self._write_archive()
        except OSError as error:
            self._problem = f"trace '{self.path}' cannot be completed: {error.strerror or error}"
        finally:
            if self._buffer is not None:
                self._buffer.close()
        if self._problem:
            raise RecordingError(self._problem)

    def _write_archive(self) -> None:
        table: np.ndarray = np.empty(0, self._dtype)
        if self._rows:
            table = np.load(self._growing, mmap_mode="r")
        with whole_file(self.path) as target, zipfile.ZipFile(target, "w") as archive:
            for name in self._dtype.names or ():
                _write(archive, name, table[name])
            for name, joints in self._joints.items():
                _write(archive, name, np.array(joints))

    def _header(self) -> bytes:
        """Return the header of an NPY file, whose length does not depend on the number of rows."""
        header = io.BytesIO()
        content = {
            "descr": np.lib.format.dtype_to_descr(self._dtype),
            "fortran_order": False,
            "shape": (self._rows,),
        }
        np.lib.format.write_array_header_1_0(header, content)
        return header.getvalue()


def read_trace(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """Return the columns of a trace by name, also of a run that goes on or was killed.

    Such a trace lacks at most the last 512 control steps.

    Args:
        path: The file of ``bt-manip run --trace``.

    Raises:
        BtManipError: If the file cannot be read or is not a trace.
    """
    with reading(path, "trace"):
        found = np.load(path)
        names = found.dtype.names if isinstance(found, np.ndarray) else found.files
        return {name: found[name] for name in names}


class TraceRecorder(RunObserver):
    """Write t, q, v, q_ref, v_ref, a_ref and tau of every control step to an .npz file.

    It is the small file of the joints; ``bt-manip export`` makes tables of everything recorded.
    """

    suffix = ".npz"

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
        self._trace.name_joints(station)
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
