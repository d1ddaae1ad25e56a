"""Log files of BehaviorTree.CPP, which Groot2 opens: every change of a status."""

import io
import sqlite3
import time
from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import IO, TYPE_CHECKING, ClassVar

from bt_manip.bt import NodeStatus, instance_to_xml
from bt_manip.exceptions import BtManipError
from bt_manip.record import RecordingError, check_exists, open_output
from bt_manip.runner import Run, RunEvent, RunObserver
from bt_manip_groot.messages import HIGHEST_UID, transition

if TYPE_CHECKING:
    from bt_manip_recording import Recording

MAGIC = b"BTCPP4-FileLogger2\x01"
"""Name and version of the format, at the beginning of a ``.btlog``."""

FLUSH = 0.5
"""Wall time after which changes are written, so that few are lost with the process [s]."""

SCHEMA = """
CREATE TABLE Transitions (timestamp  INTEGER PRIMARY KEY NOT NULL, session_id INTEGER NOT NULL,
    node_uid   INTEGER NOT NULL, duration   INTEGER, state      INTEGER NOT NULL,
    extra_data VARCHAR );
CREATE TABLE Nodes (session_id INTEGER NOT NULL, fullpath   VARCHAR, node_uid   INTEGER NOT NULL );
CREATE TABLE Definitions (session_id INTEGER PRIMARY KEY AUTOINCREMENT, date       TEXT NOT NULL,
    xml_tree   TEXT NOT NULL);
"""


class TransitionLog(RunObserver):
    """Writes each change of a node's status to a file, with its simulated time.

    The log ends when the tree is replaced by an edited one. When the disk is full, the run
    continues, and `run_ended` raises.

    Args:
        path: The file to write; an existing one is replaced.

    Raises:
        BtManipError: If there is no path.
    """

    suffix: ClassVar[str]
    kinds = ("tree", "status")

    _file: IO[bytes]  # is locked, from `_open` on

    def __init__(self, path: Path | None) -> None:
        if path is None:
            raise BtManipError(f"a log needs a file to be written to: --record FILE{self.suffix}")
        self._path = path
        self._rows: list[tuple[int, int, NodeStatus]] = []
        self._trees = 0
        self._is_open = False
        self._error: RecordingError | None = None

    def run_started(self, run: Run) -> None:
        """Open the file and write the tree."""
        nodes = [(node.path, node.uid) for node in run.tree.nodes]
        self._begin(run.station.cell.time, instance_to_xml(run.tree), nodes)

    def after_tick(self) -> None:
        """Write the changes of the last half second."""
        if time.monotonic() - self._flushed > FLUSH:
            self._flush()

    @classmethod
    def export(cls, recording: "Recording", path: Path) -> None:
        """Write the statuses of a recording; the file's time of its start is the present time.

        Raises:
            BtManipError: If the recording has no tree, or the log cannot be written.
        """
        events = [event for event in recording.events() if event.kind in ("tree", "status")]
        if not events or not recording.tree_xml:
            raise BtManipError(f"{recording.path} has no tree")
        nodes = [(node["path"], node["uid"]) for node in events[0].data["nodes"]]
        log = cls(path)
        log._begin(events[0].time, recording.tree_xml, nodes)
        for event in events:
            log.handle(event)
        log.run_ended()

    def _begin(self, start: float, xml: str, nodes: Sequence[tuple[str, int]]) -> None:
        self._start, self._flushed = start, time.monotonic()
        with self._errors_named():
            self._open(xml, nodes, time.time_ns() // 1000)
            self._is_open = True

    def run_ended(self) -> None:
        """Write the remaining transitions, and close the file."""
        if self._is_open:
            self._flush()
            self._keep_error(lambda: check_exists(self._file))
            with suppress(OSError, sqlite3.Error):  # again of data that an error has left
                self._close()
        if self._error is not None:
            raise self._error

    def handle(self, event: RunEvent) -> None:
        """Keep a change of a status."""
        if event.kind == "tree":
            self._trees += 1
        elif event.kind == "status" and self._trees == 1:
            elapsed = max(0, round((event.time - self._start) * 1e6))
            status = NodeStatus[event.data["status"]]
            self._rows.append((elapsed, event.data["uid"], status))

    def _flush(self) -> None:
        self._flushed = time.monotonic()
        rows, self._rows = self._rows, []
        self._keep_error(lambda: self._write(rows))

    def _keep_error(self, write: Callable[[], None]) -> None:
        """Write; nothing more after the first error, which `run_ended` raises."""
        if self._error is None:
            try:
                with self._errors_named():
                    write()
            except RecordingError as error:
                self._error = error

    @contextmanager
    def _errors_named(self) -> Iterator[None]:
        try:
            yield
        except (OSError, sqlite3.Error) as error:
            text = getattr(error, "strerror", None) or error
            raise RecordingError(f"log '{self._path}' cannot be written: {text}") from error

    @abstractmethod
    def _open(self, xml: str, nodes: Sequence[tuple[str, int]], now: int) -> None:
        """Open the file; write the tree, path and uid of its nodes, and microseconds since 1970."""

    @abstractmethod
    def _write(self, rows: Sequence[tuple[int, int, NodeStatus]]) -> None:
        """Append changes: microseconds since the start, uid, status."""

    @abstractmethod
    def _close(self) -> None:
        """Close the file."""


class BtlogRecorder(TransitionLog):
    """Write the changes of statuses to a ``.btlog`` file, as ``FileLogger2`` does."""

    suffix: ClassVar[str] = ".btlog"

    def _open(self, xml: str, nodes: Sequence[tuple[str, int]], now: int) -> None:
        text = xml.encode(errors="replace")
        self._file = io.BufferedWriter(open_output(self._path))
        lengths = len(text).to_bytes(4, "little"), now.to_bytes(8, "little")
        self._file.write(MAGIC + lengths[0] + text + lengths[1])
        self._file.flush()

    def _write(self, rows: Sequence[tuple[int, int, NodeStatus]]) -> None:
        self._file.write(b"".join(transition(*row) for row in rows if row[1] <= HIGHEST_UID))
        self._file.flush()

    def _close(self) -> None:
        self._file.close()


class SqliteRecorder(TransitionLog):
    """Write the changes of statuses to an SQLite database, as ``SqliteLogger`` does."""

    suffix: ClassVar[str] = ".db3"

    def _open(self, xml: str, nodes: Sequence[tuple[str, int]], now: int) -> None:
        target = self._path.resolve()
        if target.exists() and not target.is_file():
            raise RecordingError(f"log '{self._path}' cannot be written: it is no regular file")
        self._file = open_output(target)  # an empty file is an empty database
        self._database = sqlite3.connect(target)
        self._database.execute("PRAGMA synchronous=OFF")
        self._database.executescript(SCHEMA)
        self._now = self._last = now
        date = datetime.now().strftime("%Y-%m-%d %H:%M:%S")
        text = xml.encode(errors="replace").decode()
        self._database.execute(
            "INSERT INTO Definitions (date, xml_tree) VALUES (?, ?)", (date, text)
        )
        self._database.executemany("INSERT INTO Nodes VALUES (1, ?, ?)", nodes)
        self._database.commit()
        self._running_since: dict[int, int] = {}

    def _write(self, rows: Sequence[tuple[int, int, NodeStatus]]) -> None:
        check_exists(self._file)  # SQLite would call it a read-only database
        written = []
        for elapsed, uid, status in rows:
            # The time is the key: of changes in one tick, each is a microsecond later.
            self._last = max(self._last + 1, self._now + elapsed)
            started = self._running_since.pop(uid, self._last)
            if status is NodeStatus.RUNNING:
                self._running_since[uid] = self._last
            written.append((self._last, uid, self._last - started, status.value))
        self._database.executemany("INSERT INTO Transitions VALUES (?, 1, ?, ?, ?, '')", written)
        self._database.commit()

    def _close(self) -> None:
        self._database.close()
        self._file.close()
