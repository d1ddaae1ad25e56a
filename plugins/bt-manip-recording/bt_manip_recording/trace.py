"""Trace of a run: every control step, as a file."""

import io
import os
import zipfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.record import (
    AppendedFile,
    RecordingError,
    check_writable,
    is_special,
    reading,
    whole_file,
    writing,
)
from bt_manip.runner import STEP_FIELDS, Run, RunObserver, StepBlock


def columns_of(blocks: Mapping[str, StepBlock]) -> tuple[np.ndarray, list[np.ndarray], list[str]]:
    """Return times, traced columns of robots and their names; with several, ``robot/column``.

    Args:
        blocks: The same control steps of each robot, by its name.
    """
    prefixes = {name: f"{name}/" if len(blocks) > 1 else "" for name in blocks}
    columns = [getattr(block, column) for block in blocks.values() for column in STEP_FIELDS]
    names = [prefix + column for prefix in prefixes.values() for column in STEP_FIELDS]
    return next(iter(blocks.values())).t, columns, names


def joints_of(robots: Mapping[str, Sequence[str]]) -> dict[str, Sequence[str]]:
    """Return the joints of robots by their names in a trace; with several, ``robot/joints``."""
    return {f"{n}/joints" if len(robots) > 1 else "joints": joints for n, joints in robots.items()}


class Trace(RunObserver):
    """Write t, q, v, q_ref, v_ref, a_ref and tau of every control step to an .npz file.

    It is the small file of the joints; ``bt-manip export`` makes tables of everything recorded.
    With several robots in a cell the file has ``left/q`` and so on, by their names.

    While the run goes on, the file is a structured array in NumPy's NPY format with the same names,
    which grows; `read_trace` and ``np.load`` read both. At the end it is replaced by the archive,
    which has the names of the joints, too: ``joints``.

    Args:
        path: The file to write.

    Raises:
        BtManipError: When there is no path, or the file cannot be written.
    """

    suffix = ".npz"

    def __init__(self, path: Path | None) -> None:
        if path is None:
            raise BtManipError("a trace needs a file to be written to: --record trace=FILE.npz")
        check_writable(path, "trace")
        if is_special(path):
            raise BtManipError(f"trace '{path}' cannot be written: a pipe or device cannot grow")
        self.path = path
        self._file: AppendedFile | None = None
        self._dtype = np.dtype([("t", float), *((name, float, (0,)) for name in STEP_FIELDS)])
        self._rows = 0
        self._problem = ""
        self._is_closed = False
        self._joints: dict[str, Sequence[str]] = {}  # by name in the archive

    def run_started(self, run: Run) -> None:
        """Open the file, name the joints and ask for the control steps.

        Raises:
            FileInUseError: If another process is writing it.
        """
        with suppress(OSError):  # raised again with the first steps
            self._file = self._file or AppendedFile(self.path)
        robots = run.station.robots
        self._joints = joints_of({n: r.robot.description.arm_joints for n, r in robots.items()})
        run.log.steps(lambda blocks: self.append(*columns_of(blocks)))

    def append(
        self, t: np.ndarray, columns: Sequence[np.ndarray], names: Sequence[str] = STEP_FIELDS
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
            self._file = self._file or AppendedFile(self.path)
            if not self._file.size:
                widths = ((n, float, c.shape[1:]) for n, c in zip(names, columns, strict=True))
                self._dtype = np.dtype([("t", float), *widths])
                self._file.append(self._header())
            self._file.append(np.column_stack((t, *columns)).tobytes())
            self._rows += len(t)
            self._file.overwrite(self._header())
        except OSError as error:
            self._problem = (
                f"trace '{self.path}' cannot be written: {error.strerror}; the steps from "
                f"{t[0]:.3f} s on are lost"
            )

    def run_ended(self) -> None:
        """Write the file, unless it is in use by another process."""
        if self._file is not None or self._problem:
            self.close()

    def close(self) -> None:
        """Replace the file by the archive; the end of a run does so, too.

        Raises:
            RecordingError: When it cannot be written.
        """
        if self._is_closed:
            return
        self._is_closed = True
        try:
            if self._file is not None:
                self._file.sync()
            if not self._problem:
                table = (
                    np.load(self.path, mmap_mode="r") if self._rows else np.empty(0, self._dtype)
                )
                columns = {name: table[name] for name in self._dtype.names or ()}
                _write_archive(self.path, columns, self._joints)
        except OSError as error:
            self._problem = f"trace '{self.path}' cannot be completed: {error.strerror or error}"
        finally:
            if self._file is not None:
                self._file.close()
        if self._problem:
            raise RecordingError(self._problem)

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


def write_trace(
    path: Path, blocks: Mapping[str, StepBlock], joints: Mapping[str, Sequence[str]]
) -> None:
    """Write control steps as the trace of a run.

    Args:
        path: The file to write.
        blocks: The same control steps of each robot, by its name.
        joints: Names of the joints, by robot.

    Raises:
        RecordingError: When it cannot be written.
    """
    t, columns, names = columns_of(blocks)
    with writing(path, "trace"):
        _write_archive(
            path, dict(zip(("t", *names), (t, *columns), strict=True)), joints_of(joints)
        )


def _write_archive(
    path: Path, columns: Mapping[str, np.ndarray], joints: Mapping[str, Sequence[str]]
) -> None:
    """Write the columns of a trace and the names of the joints."""
    texts = {name: np.array(names) for name, names in joints.items()}
    with whole_file(path) as target, zipfile.ZipFile(target, "w") as archive:
        for name, column in {**columns, **texts}.items():
            member = zipfile.ZipInfo(f"{name}.npy")  # without a time stamp: same run, same bytes
            with archive.open(member, "w", force_zip64=True) as file:
                np.lib.format.write_array(file, column)
