"""Folders of results: Parquet files, and a journal of the latest results."""

import fcntl
import json
import os
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import fields
from pathlib import Path
from types import NoneType
from typing import Any, get_args

import pyarrow as pa
from pyarrow import parquet

from bt_manip.exceptions import BtManipError
from bt_manip.record import reading, whole_file, writing
from bt_manip.runner import ParameterSet

from .episode import EpisodeResult, refuse_difference

IDENTITY = "_evaluation.json"
"""File with the identity of the run; readers of Parquet folders ignore names with ``_``."""

JOURNAL = "_latest.jsonl"
"""File of the results that are in no Parquet file yet, one line each."""

PART_ROWS = 1000
"""Number of results in a Parquet file."""

PART_TIME = 60.0
"""Wall time after which a Parquet file with fewer results is written [s]."""

METADATA = b"bt_manip"
"""Key of the identity, as JSON, in the metadata of the Parquet files."""

_TYPES = {int: pa.int64(), float: pa.float64(), bool: pa.bool_(), str: pa.string()}
"""Column type of each field type of an `EpisodeResult`; every column may be null."""


class ResultFolder:
    """A folder that gets one row for each episode; each row is kept from the moment it is added.

    ``pyarrow.parquet.read_table(folder)`` or ``pandas.read_parquet(folder)`` reads it. The varied
    parameters become columns; `results` are those of earlier evaluations in the folder.

    Raises:
        BtManipError: If the folder cannot be written, is of another evaluation, or is being
            written by another process.
    """

    def __init__(
        self, path: Path, identity: Mapping[str, Any], points: Sequence[ParameterSet]
    ) -> None:
        self._path, self._points = path, points
        kept = path / IDENTITY
        with writing(path, "results"):
            path.mkdir(parents=True, exist_ok=True)
            flags = os.O_RDWR | os.O_CREAT | os.O_APPEND
            self._journal = os.open(path / JOURNAL, flags, 0o666)
        with ExitStack() as stack:
            stack.callback(os.close, self._journal)
            try:
                fcntl.flock(self._journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise BtManipError(f"'{path}' is being written by another evaluation") from None
            if kept.exists():
                with reading(kept, "evaluation"):
                    refuse_difference(f"'{path}'", json.loads(kept.read_text()), identity)
            else:
                with writing(kept, "results"), whole_file(kept) as file:
                    file.write(json.dumps(dict(identity), indent=1).encode())
            self._schema = _schema(points).with_metadata({METADATA: json.dumps(dict(identity))})
            self._written = time.monotonic()
            parts = sorted(path.glob("part-*.parquet"))
            self._next = int(parts[-1].stem[5:]) + 1 if parts else 0
            kept_rows, self._rows = _rows_of(path, identity)
            self.results = kept_rows + self._rows
            stack.pop_all()

    def add(self, result: EpisodeResult) -> None:
        """Keep a result: from now on it survives ``kill -9``."""
        with writing(self._path, "results"):
            os.write(self._journal, json.dumps(vars(result)).encode() + b"\n")
        self._rows.append(result)
        if len(self._rows) >= PART_ROWS or time.monotonic() - self._written > PART_TIME:
            self._flush()

    def close(self) -> None:
        """Write the remaining results to a Parquet file."""
        try:
            self._flush()
            if not os.fstat(self._journal).st_size:
                with suppress(OSError):
                    (self._path / JOURNAL).unlink()
        finally:
            os.close(self._journal)

    def __enter__(self) -> "ResultFolder":
        """Return the folder."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close it."""
        self.close()

    def _flush(self) -> None:
        """Move the rows of the journal to a Parquet file."""
        self._written = time.monotonic()
        if self._rows:
            rows = [vars(one) | _parameters(self._points[one.point]) for one in self._rows]
            path = self._path / f"part-{self._next:05}.parquet"
            with writing(path, "results"), whole_file(path) as file:
                parquet.write_table(pa.Table.from_pylist(rows, self._schema), file)
            self._next, self._rows = self._next + 1, []
        os.ftruncate(self._journal, 0)


def read_results(path: Path) -> tuple[dict[str, Any], list[EpisodeResult]]:
    """Return identity and results of a folder, in the order of points and episodes.

    Raises:
        BtManipError: If it is no such folder.
    """
    with reading(path / IDENTITY, "evaluation"):
        identity = json.loads((path / IDENTITY).read_text())
    results = [result for results in _rows_of(path, identity) for result in results]
    return identity, sorted(results, key=lambda one: (one.point, one.episode))


def _rows_of(
    path: Path, identity: Mapping[str, Any]
) -> tuple[list[EpisodeResult], list[EpisodeResult]]:
    """Return the results in a folder's Parquet files, and those in its journal alone."""
    columns, kept = {one.name for one in fields(EpisodeResult)}, {}
    for part in sorted(path.glob("part-*.parquet")):
        with reading(part, "part of an evaluation"):
            table = parquet.read_table(part)
            written_for = json.loads((table.schema.metadata or {})[METADATA])
            refuse_difference(f"'{part}'", written_for, identity)
            for row in table.select([n for n in table.column_names if n in columns]).to_pylist():
                kept[row["point"], row["episode"]] = EpisodeResult(**row)
    latest = []
    journal = path / JOURNAL
    for line in journal.read_bytes().split(b"\n")[:-1] if journal.exists() else ():
        with suppress(ValueError, TypeError):  # a killed process may have left half a line
            result = EpisodeResult(**json.loads(line))
            if (result.point, result.episode) not in kept:
                latest.append(result)
    return list(kept.values()), latest


def _schema(points: Sequence[ParameterSet]) -> pa.Schema:
    columns = {}
    for one in fields(EpisodeResult):
        (kind,) = {*(get_args(one.type) or (one.type,))} - {NoneType}
        columns[one.name] = _TYPES[kind]
    for name in _parameters(points[0]):
        values = [_parameters(point)[name] for point in points]
        try:
            columns[name] = pa.array(values).type
        except pa.ArrowInvalid:
            raise BtManipError(f"the values of {name} are of different types") from None
    return pa.schema(columns)


def _parameters(point: ParameterSet) -> dict[str, Any]:
    return {f"vary.{name}": value for name, value in point.items()}
