"""Files of reports: written while the run goes on, and read."""

import io
import json
import os
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import is_dataclass, replace
from functools import cache
from pathlib import Path
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

from bt_manip.files import check_regular
from bt_manip.record.files import (
    AppendedFile,
    RecordingError,
    is_locked,
    is_special,
    lock,
    open_output,
    reading,
    whole_file,
)
from bt_manip.record.report.run_report import CycleReport, RunReport, plain, plain_cycle

PERIOD = 1.0
"""Minimum wall time between two versions of a JSON report [s]: writing a long one takes ms."""

SHARE = 0.05
"""Maximum share of time that JSON reports take of a processor: long ones are written less often."""

SUMMARY = ("status", "simulated_s", "wall_s", "real_time_factor", "state_digest", "error")
"""Fields of `RunReport` that are known at the end of the run."""


NO_END = "the run ended without an end: its process was killed or has left"
"""Error of a report that nobody writes any more."""


class ReportFile(ABC):
    """A report in a file, kept up to date while its run goes on; the first failure is warned of."""

    def __init__(self, path: Path, warn: Callable[[str], None]) -> None:
        self._path, self._warn = path, warn
        self._warned = False
        self._written = 0  # cycles in the file

    def update(self, report: RunReport) -> None:
        """Write the cycles that have ended; after a failure they are written later.

        The report has the status ``"RUNNING"``. A file that another process writes is refused.
        """
        try:
            self._write(report)
        except OSError as error:
            self._failed(error)

    def close(self, report: RunReport) -> None:
        """Write the whole report; an error names the file and the first cycle that is lost."""
        try:
            self._write(report, final=True)
        except OSError as error:
            raise RecordingError(self._problem(error, len(report.cycles))) from error

    @abstractmethod
    def _write(self, report: RunReport, *, final: bool = False) -> None:
        """Write the missing part of the file."""

    def _failed(self, error: OSError) -> None:
        if not self._warned:
            self._warned = True
            self._warn(f"{self._problem(error)}; the run continues")

    def _problem(self, error: OSError, cycles: int | None = None) -> str:
        what = f"report '{self._path}' cannot be written: {error.strerror or error}"
        if cycles is not None and self._written >= cycles:
            return f"{what}; it has all cycles, its summary is lost"
        return f"{what}; cycle {self._written + 1} is the first that is lost"


class JsonReportFile(ReportFile):
    """A report as one JSON object: rewritten at most once a `PERIOD`, and at the end.

    Each version replaces the one before, so the file is complete at any time. Where a cycle ends
    within the `PERIOD`, a thread writes the version that is due at its end, also if the run hangs.
    """

    def __init__(self, path: Path, warn: Callable[[str], None]) -> None:
        super().__init__(path, warn)
        self._lock = threading.Lock()
        self._timer: threading.Timer | None = None
        self._due = 0.0
        self._cycles: list[str] = []  # as JSON
        self._locked: io.FileIO | None = None  # the present version

    def _write(self, report: RunReport, *, final: bool = False) -> None:
        if not final and is_special(self._path):  # a pipe or a device takes one version
            return
        with self._lock:
            self._report = report
            self._cycles += [_cycle_text(cycle) for cycle in report.cycles[len(self._cycles) :]]
            wait = self._due - time.monotonic()
            if (final or wait <= 0.0) and self._timer is not None:
                self._timer.cancel()
                self._timer = None
            if final or wait <= 0.0:
                self._rewrite(sync=final)
                if final and self._locked is not None:
                    self._locked.close()
            elif self._timer is None:
                self._timer = threading.Timer(wait, self._rewrite_later)
                self._timer.daemon = True
                self._timer.start()

    def _rewrite_later(self) -> None:
        with self._lock:
            if self._timer is None:  # another version has been written
                return
            self._timer = None
            try:
                self._rewrite(sync=False)
            except OSError as error:
                self._failed(error)

    def _rewrite(self, *, sync: bool) -> None:
        start = time.thread_time()
        text = replace(self._report, cycles=()).to_json()
        if self._cycles:
            cycles = ",\n".join(self._cycles)
            text = text.replace('"cycles": []', f'"cycles": [\n{cycles}\n  ]', 1)
        try:
            if self._locked is None and not is_special(self._path):
                self._locked = open_output(self._path, empty=False)
            with whole_file(self._path, sync=sync) as file:
                file.write(text.encode())
                locked = None
                if self._locked is not None:
                    locked = io.FileIO(os.dup(file.fileno()), "r+b")
                    lock(locked)
            if self._locked is not None:
                self._locked.close()
                self._locked = locked
            self._written = len(self._cycles)
        finally:
            took = time.thread_time() - start
            self._due = time.monotonic() + max(PERIOD, took / SHARE)


class JsonLinesReportFile(ReportFile):
    """A report that grows by a line for each cycle.

    Each line is an object with a ``type``: ``run`` (the first line: what was run), ``cycle``, and
    ``end`` (the last line: the fields of `SUMMARY`).
    """

    _file: AppendedFile | None = None

    def _write(self, report: RunReport, *, final: bool = False) -> None:
        content = plain(replace(report, cycles=()))
        summary = {key: content.pop(key) for key in SUMMARY}
        del content["cycles"]
        if self._file is None:
            self._file = AppendedFile(self._path)
        if not self._file.size:
            self._file.append(_line("run", content))
        for cycle in report.cycles[self._written :]:
            self._file.append(_line("cycle", plain_cycle(cycle)))
            self._written += 1
        if final:
            self._file.append(_line("end", summary))
            self._written = 0  # if the file was deleted
            try:
                self._file.sync()
            finally:
                self._file.close()
            self._written = len(report.cycles)


def open_report_file(path: Path, warn: Callable[[str], None]) -> ReportFile:
    """Return the file of a report, JSON Lines for a name that ends with ``.jsonl``."""
    kind = JsonLinesReportFile if path.suffix == ".jsonl" else JsonReportFile
    return kind(path, warn)


def read_report(path: str | os.PathLike[str]) -> RunReport:
    """Return the report in a file, also of a run that goes on or was killed.

    In a ``.jsonl`` file, a last line without an end is left out. Without its last line, the run has
    the simulated time of its cycles. A run without an end has the status ``"RUNNING"`` while its
    process writes the file, and ``"ERROR"`` with the error `NO_END` afterwards.

    Args:
        path: The file of ``bt-manip run --report``.

    Raises:
        BtManipError: If the file cannot be read or is not a report.
    """
    with reading(path, "report"):
        path = Path(path)
        check_regular(path)
        goes_on = is_locked(path)
        text = path.read_bytes().decode()
        content = _from_lines(text) if path.suffix == ".jsonl" else json.loads(text)
        report: RunReport = _value(RunReport, content)
    if report.status == "RUNNING" and not goes_on:
        return replace(report, status="ERROR", error=NO_END)
    return report


def _from_lines(text: str) -> dict[str, Any]:
    content: dict[str, Any] = {}
    cycles = []
    for number, line in enumerate(text.split("\n")[:-1], 1):
        try:
            entry = json.loads(line)
            kind = entry.pop("type")
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise ValueError(f"line {number}: {error}") from error
        if kind == "cycle":
            cycles.append(entry)
        else:
            content.update(entry)
    simulated = round(sum(float(cycle["duration_s"]) for cycle in cycles), 6)
    return {"status": "RUNNING", "simulated_s": simulated} | content | {"cycles": cycles}


def _value(kind: Any, value: Any) -> Any:
    """Convert a value of JSON to the type of a field of a report; unknown keys are ignored."""
    if isinstance(kind, UnionType):
        kind = next(one for one in get_args(kind) if one is not type(None))
        return None if value is None else _value(kind, value)
    if isinstance(kind, type) and is_dataclass(kind):
        hints = _hints(kind)
        if not isinstance(value, dict):
            raise TypeError(f"expected an object, got {value!r:.40}")
        return kind(**{key: _value(hints[key], value[key]) for key in hints if key in value})
    if get_origin(kind) is tuple:
        inner = get_args(kind)
        if not isinstance(value, list):
            raise TypeError(f"expected an array, got {value!r:.40}")
        return tuple(_value(inner[0], item) for item in value)
    if get_origin(kind) is dict:
        if not isinstance(value, dict):
            raise TypeError(f"expected an object, got {value!r:.40}")
        return {key: _value(get_args(kind)[1], item) for key, item in value.items()}
    return value


_hints = cache(get_type_hints)


def _line(kind: str, content: dict[str, Any]) -> bytes:
    text = json.dumps({"type": kind, **content}, allow_nan=False, separators=(",", ":"))
    return f"{text}\n".encode()


def _cycle_text(cycle: CycleReport) -> str:
    """Return a cycle as `RunReport.to_json` has it."""
    lines = json.dumps(plain_cycle(cycle), indent=2, allow_nan=False).split("\n")
    return "\n".join(f"    {line}" for line in lines)
