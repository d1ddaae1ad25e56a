"""Writing snapshots of a run and resuming from them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bt_manip.cli.plugin_options import print_warning
from bt_manip.exceptions import BtManipError, shown
from bt_manip.recording import Recorder
from bt_manip.runner import (
    Run,
    RunObserver,
    RunRequest,
    is_scene_file,
    load_snapshot,
    save_snapshot,
)


class SnapshotTaker(RunObserver):
    """Writes a snapshot after the first tick that ends at a time or later.

    It is called after the recorder, whose state of that tick is part of the snapshot.
    """

    def __init__(self, at: float, path: Path, recorder: Recorder) -> None:
        """Set the time.

        Args:
            at: Simulated time of the cell [s].
            path: The file.
            recorder: The recorder of the run's report.
        """
        self._at, self._path, self._recorder = at, path, recorder
        self._taken = False

    def run_started(self, run: Run) -> None:
        """Keep the run."""
        self._run = run
        self._taken = False

    def after_tick(self) -> None:
        """Write the snapshot at its time."""
        cell = self._run.station.cell
        if self._taken or cell.time < self._at - 0.5 * cell.dt:
            return
        self._taken = True
        save_snapshot(
            self._path,
            {
                "request": _asked(self._run.request),
                "run": self._run.get_state(),
                "recorder": self._recorder.get_state(),
            },
        )

    def run_ended(self) -> None:
        """Print a warning if the run ended before."""
        if not self._taken:
            end = self._run.station.cell.time
            print_warning(
                f"--snapshot-at {self._at:g}: the run ended at {end:.3f} s, '{self._path}' is not "
                "written"
            )


def takers(wanted: Sequence[tuple[float, Path]], recorder: Recorder) -> list[SnapshotTaker]:
    """Return an observer for each snapshot."""
    return [SnapshotTaker(at, path, recorder) for at, path in wanted]


def load_run(path: Path) -> dict[str, Any]:
    """Return the snapshot of a run.

    Raises:
        BtManipError: If the file cannot be read, or is not a snapshot of a run.
    """
    snapshot = load_snapshot(path)
    parts = [snapshot.get(key) for key in ("request", "run", "recorder")]
    if not all(isinstance(part, Mapping) for part in parts):
        raise BtManipError(f"{path} is no snapshot of a run: bt-manip run --snapshot-at makes them")
    if not isinstance(snapshot["request"].get("seed", 0), int):
        raise BtManipError(f"{path}: the seed of the run is no number")
    return snapshot


def go_on(path: Path, snapshot: Mapping[str, Any], run: Run, recorder: Recorder) -> None:
    """Restore a run from a snapshot.

    Args:
        path: The file of the snapshot, for messages.
        snapshot: Its content.
        run: The run, prepared by a request like that of the snapshot.
        recorder: The recorder of its report.

    Raises:
        BtManipError: If the request differs, or the snapshot does not fit.
    """
    for key, now in _asked(run.request).items():
        then = snapshot["request"].get(key)
        if then != now:
            raise BtManipError(f"{path} is of a run with {key} {then!r}, this one has {now!r}")
    try:
        run.set_state(snapshot["run"])
        recorder.set_state(snapshot["recorder"])
    except BtManipError as error:
        raise BtManipError(f"{path} does not fit this run: {error}") from error
    except Exception as error:  # of whatever reads a part of the state
        raise BtManipError(f"{path} does not fit this run: {shown(error)}") from error


def _asked(request: RunRequest) -> dict[str, Any]:
    """Return the options that a resumed run must share with the interrupted one."""
    asked: dict[str, Any] = {
        "robot": request.robot,
        "controller": request.controller,
        "planner": request.planner,
        "seed": request.seed,
        "tick": request.tick,
        "settings": dict(request.settings),
    }
    if not is_scene_file(request.scene):  # the path of a file may have changed
        asked["scene"] = request.scene
    return asked
