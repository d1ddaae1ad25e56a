"""Snapshots of a run with its request and the digest of its report."""

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError, shown
from bt_manip.record.files import RecordingError
from bt_manip.record.identification import identify, identity_differences
from bt_manip.record.report.recorder import Recorder
from bt_manip.record.report.run_report import versions
from bt_manip.runner import Run, RunObserver, RunRequest, load_snapshot, save_snapshot
from bt_manip.scenes import PHYSICS


def request_fields(request: RunRequest) -> dict[str, Any]:
    """Return the request of a run as plain data; the options of reading its tree are left out."""
    return {
        "tree": request.tree.name,
        "robot": str(request.robot),
        "controller": request.controller,
        "scene": str(request.scene),
        "planner": request.planner,
        "cycles": request.cycles,
        "seed": request.seed,
        "tick": request.tick,
        "settings": dict(request.settings),
        "configurations": dict(request.configurations),
        **({} if request.tool_speed is None else {"tool_speed": request.tool_speed}),
        **({} if request.poses == PHYSICS else {"poses": request.poses}),
    }


def _identity(run: Run) -> dict[str, Any]:
    return _plain(identify(run) | {"versions": versions()})


def _plain(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields as they are read from a file."""
    return json.loads(json.dumps(fields))


def _by_name(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields with the names of files instead of their paths, which may be others."""
    files = ("tree", "scene", "robot")
    return {**fields, **{key: re.sub(r"[^, ]*/", "", str(fields.get(key))) for key in files}}


def take_snapshot(run: Run) -> dict[str, Any]:
    """Return request, state and digest of a run between two ticks, as plain data.

    The digest is empty unless an observer has asked the run's log for it.
    """
    return {
        "request": request_fields(run.request),
        "run": run.get_state(),
        "recorder": {"digest": run.log.digest.hex()},
    }


class SnapshotAt(RunObserver):
    """Takes a snapshot after the first tick that ends at a time or later.

    Attributes:
        time: Simulated time of the cell [s].
        taken: Whether the snapshot has been taken.
    """

    def __init__(self, time: float, use: Callable[[dict[str, Any]], None]) -> None:
        self.time, self._use = time, use
        self.taken = False

    def run_started(self, run: Run) -> None:
        """Ask for the digest of the run."""
        run.log.keep_digest()
        self._run, self._cell = run, run.station.cell
        self.taken = False

    def after_tick(self) -> None:
        """Take the snapshot at its time."""
        if not self.taken and self._cell.time > self.time - 0.5 * self._cell.dt:
            self.taken = True
            self._use(take_snapshot(self._run))


class SnapshotWriter(SnapshotAt):
    """Writes a snapshot to a file after the first tick that ends at a time or later.

    It warns if the run ended before, or the file cannot be written.
    """

    def __init__(self, time: float, path: Path, warn: Callable[[str], None]) -> None:
        super().__init__(time, self._write)
        self._path, self._warn, self._problem = path, warn, ""

    def _write(self, snapshot: dict[str, Any]) -> None:
        try:
            save_snapshot(self._path, snapshot | {"identity": _identity(self._run)})
        except BtManipError as error:
            self._problem = str(error)
            self._warn(f"{error}; the run continues")

    def run_ended(self) -> None:
        """Warn if the run ended before; raise if the file could not be written."""
        if self._problem:
            raise RecordingError(self._problem)
        if not self.taken:
            self._warn(
                f"--snapshot-at {self.time:g}: the run ended at {self._cell.time:.3f} s, "
                f"'{self._path}' is not written"
            )


def read_snapshot(path: Path) -> dict[str, Any]:
    """Return the snapshot of a run in a file; raise a `BtManipError` for other files."""
    snapshot = load_snapshot(path)
    parts = [snapshot.get(key) for key in ("request", "run", "recorder")]
    if not all(isinstance(part, Mapping) for part in parts):
        raise BtManipError(f"{path} is no snapshot of a run: bt-manip run --snapshot-at makes them")
    if not isinstance(snapshot.get("identity"), Mapping):
        raise BtManipError(f"{path} does not say what was run: an older version has written it")
    if not isinstance(snapshot["request"].get("seed", 0), int):
        raise BtManipError(f"{path}: the seed of the run is no number")
    return snapshot


def restore_snapshot(
    where: object, snapshot: Mapping[str, Any], run: Run, recorder: Recorder
) -> None:
    """Restore a run from a snapshot.

    Args:
        where: Where the snapshot is from, for messages.
        snapshot: What `take_snapshot` returned.
        run: The run, prepared by a request like that of the snapshot.
        recorder: The recorder of its report.

    Raises:
        BtManipError: If the request differs, or the snapshot does not fit.
    """
    then, now = snapshot["request"], _plain(request_fields(run.request))
    if "identity" in snapshot:
        then, now = then | snapshot["identity"], now | _identity(run)
        for name in then.get("modifiers", ()):
            raise BtManipError(
                f"{where} is of a run with --{name}, which cannot be continued: the same options "
                "of bt-manip run repeat it from its start"
            )
    differences = identity_differences(_by_name(then), _by_name(now))
    if differences:
        raise BtManipError(f"{where} is of another run: {'; '.join(differences.values())}")
    try:
        run.set_state(snapshot["run"])
        recorder.set_state(snapshot["recorder"])
    except BtManipError as error:
        raise BtManipError(f"{where} does not fit this run: {error}") from error
    except Exception as error:  # of whatever reads a part of the state
        raise BtManipError(f"{where} does not fit this run: {shown(error)}") from error
