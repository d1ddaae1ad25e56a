"""Snapshots of a run from the command line: kept at a time, gone on from later."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bt_manip.cli.plugin_options import print_warning
from bt_manip.exceptions import BtManipError
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
    """Keeps the moment after the first tick that ends at a time or later.

    It stands behind the recorder, whose state of that tick goes into the file, too.
    """

    def __init__(self, at: float, path: Path, recorder: Recorder) -> None:
        """Wait for a time.

        Args:
            at: Simulated time of the cell [s].
            path: The file.
            recorder: What gathers the run's report.
        """
        self._at, self._path, self._recorder = at, path, recorder
        self._taken = False

    def run_started(self, run: Run) -> None:
        """Note what is taken."""
        self._run = run
        self._taken = False

    def after_tick(self) -> None:
        """Take the snapshot when it is time."""
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
        """Say when there is none."""
        if not self._taken:
            end = self._run.station.cell.time
            print_warning(
                f"--snapshot-at {self._at:g}: the run ended at {end:.3f} s, '{self._path}' is not "
                "written"
            )


def takers(wanted: Sequence[tuple[float, Path]], recorder: Recorder) -> list[SnapshotTaker]:
    """Make what takes each of some snapshots."""
    return [SnapshotTaker(at, path, recorder) for at, path in wanted]


def load_run(path: Path) -> dict[str, Any]:
    """Read the snapshot of a run.

    Raises:
        BtManipError: When the file cannot be read, or is no snapshot of a run.
    """
    snapshot = load_snapshot(path)
    if not isinstance(snapshot, Mapping) or not {"request", "run", "recorder"} <= snapshot.keys():
        raise BtManipError(f"{path} is no snapshot of a run: bt-manip run --snapshot-at makes them")
    return dict(snapshot)


def go_on(path: Path, snapshot: Mapping[str, Any], run: Run, recorder: Recorder) -> None:
    """Let a run go on from a snapshot.

    Args:
        path: The snapshot's file, for messages.
        snapshot: What is in it.
        run: The run, prepared by a request like that of the snapshot.
        recorder: What gathers its report.

    Raises:
        BtManipError: When the request is another one, or the snapshot does not fit.
    """
    for key, now in _asked(run.request).items():
        then = snapshot["request"].get(key)
        if then != now:
            raise BtManipError(f"{path} is of a run with {key} {then!r}, this one has {now!r}")
    try:
        run.set_state(snapshot["run"])
        recorder.set_state(snapshot["recorder"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BtManipError(f"{path} does not fit this run: {error!r}") from error


def _asked(request: RunRequest) -> dict[str, Any]:
    """Give what a run that goes on has to have in common with the one that was left."""
    asked: dict[str, Any] = {
        "robot": request.robot,
        "controller": request.controller,
        "planner": request.planner,
        "seed": request.seed,
        "tick": request.tick,
        "settings": dict(request.settings),
    }
    if not is_scene_file(request.scene):  # whose path may be another one by then
        asked["scene"] = request.scene
    return asked
