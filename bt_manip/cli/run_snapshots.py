"""Writing snapshots of a run and resuming from them."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from bt_manip.cli.plugin_options import print_warning
from bt_manip.exceptions import BtManipError
from bt_manip.record import SnapshotAt
from bt_manip.runner import load_snapshot, save_snapshot


class SnapshotTaker(SnapshotAt):
    """Writes a snapshot after the first tick that ends at a time or later."""

    def __init__(self, at: float, path: Path) -> None:
        """Set the time.

        Args:
            at: Simulated time of the cell [s].
            path: The file.
        """
        super().__init__(at, partial(save_snapshot, path))
        self._path = path

    def run_ended(self) -> None:
        """Print a warning if the run ended before."""
        if not self.taken:
            end = self._run.station.cell.time
            print_warning(
                f"--snapshot-at {self.time:g}: the run ended at {end:.3f} s, '{self._path}' is not "
                "written"
            )


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
