"""Continuing a recorded run from any of its moments."""

import hashlib
import sys
from collections.abc import Mapping
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError
from bt_manip.files import read_bytes
from bt_manip.record import (
    Recorder,
    SnapshotAt,
    identify,
    identity_differences,
    reading,
    restore_snapshot,
    versions,
)
from bt_manip.runner import Run, RunModifier, RunRequest, TreeSource, find_tree
from bt_manip_recording.mcap_recorder import SNAPSHOTS
from bt_manip_recording.recording import Recording


class RecordedInterventions(RunModifier):
    """Repeats the interventions of a recording at their ticks."""

    def __init__(self, recording: Recording) -> None:
        self._decoding = recording.decoding
        self._recorded = [(event.time, event.data) for event in recording.events("intervention")]

    def run_started(self, run: Run) -> None:
        """Skip the interventions before the present state of the run."""
        self._run, self._cell = run, run.station.cell
        start = self._cell.time - 0.5 * self._cell.dt
        self._left = [one for one in reversed(self._recorded) if one[0] > start]

    def before_tick(self) -> None:
        """Request the interventions of this tick."""
        while self._left and self._left[-1][0] < self._cell.time + 0.5 * self._cell.dt:
            with self._decoding():
                self._run.interventions.request(self._left.pop()[1])


class Continuation:
    """A recorded run to be continued from one of its moments.

    Code that a recording names is not imported: a recording may come from anybody.

    Args:
        recording: The recording.
        time: Simulated time of the moment [s].
        tree: The tree of the recording, as the user names it; only needed if it is in Python, whose
            code then runs if it has the recorded SHA-256. Empty: the one that the recording names.

    Attributes:
        recording: The recording.
        time: Simulated time of the moment [s].
        fields: The request of the run, as plain data.

    Raises:
        BtManipError: If there is none, or the run cannot be continued.
    """

    def __init__(self, recording: Recording, time: float, tree: str = "") -> None:
        self.recording, self.time, self._tree = recording, time, tree
        where = recording.path
        modified = {f"--{name}": True for name in recording.identity.get("modifiers", ())}
        for option, given in {**modified, "--vary": recording.identity.get("varied")}.items():
            if given:
                raise BtManipError(
                    f"{where} is of a run with {option}, which cannot be continued: the same "
                    "options of bt-manip run repeat it from its start"
                )
        if recording.identity.get("agent"):
            raise BtManipError(
                f"{where} is of an environment's episode, in which an agent acted; a tree cannot "
                "continue it"
            )
        snapshots = recording.messages(SNAPSHOTS) if SNAPSHOTS in recording.topics else ()
        self._snapshot: Mapping[str, Any] = {}
        for at, _, data in snapshots:
            if at <= time + 1e-6:
                self._snapshot = data
        if not self._snapshot:
            raise BtManipError(f"{where} has no snapshot at or before {time:g} s to continue from")
        if time > recording.end:
            raise BtManipError(f"{where} ends at {recording.end:.3f} s, before {time:g} s")
        with recording.decoding():
            fields = self._snapshot["request"]
            self.fields: Mapping[str, Any] = {**fields, "tree": tree or str(fields["tree"])}

    @property
    def interventions(self) -> RunModifier:
        """A modifier that repeats the recorded interventions."""
        return RecordedInterventions(self.recording)

    def request(self, trees: Mapping[str, str], **others: Any) -> RunRequest:
        """Return the request of the recorded run.

        Args:
            trees: The registered trees, as for `bt_manip.runner.find_tree`.
            **others: Further fields of the request.

        Raises:
            BtManipError: If the tree is not there, or is in Python and the user has not named it,
                or its file is not the recorded one.
        """
        fields = dict(self.fields)
        source = find_tree(fields.pop("tree"), trees)
        if source.kind == "python" and source.name not in trees:
            self._check_code(source)
        return RunRequest(source, **fields, **others)

    def _check_code(self, source: TreeSource) -> None:
        """Check that the code of a tree may run; nothing is imported."""
        where = self.recording.path
        if not self._tree:
            raise BtManipError(
                f"{where} is of a tree in Python, '{source.name}', whose code would run: if you "
                f"trust it, say so with --tree {source.name}"
            )
        path = source.path or _module_file(source.module or "")
        if path is None:
            raise BtManipError(f"there is no file of the module '{source.module}'")
        recorded = self.recording.identity
        self._check_file(path, recorded.get("sha256", {}).get(path.name, ""))
        for name, digest in recorded.get("modules", {}).items():
            imported = None if name in sys.modules else _module_file(name, str(path.parent))
            if imported is not None:
                self._check_file(imported, digest)

    def _check_file(self, path: Path, recorded: str) -> None:
        """Check that a file has one of the recorded SHA-256, which spaces separate."""
        with reading(path, "tree"):
            digest = hashlib.sha256(read_bytes(path)).hexdigest()
        if digest not in recorded.split():
            raise BtManipError(
                f"{self.recording.path} cannot be continued: {path} is not the file that was "
                "recorded (SHA-256)"
            )

    def differences(self, run: Run) -> list[str]:
        """Return the differences from the installation that recorded the run, as warnings.

        Args:
            run: The run, prepared by the same request.

        Raises:
            BtManipError: If a file of tree, scene or robot has changed since.
        """
        then, now = self.recording.identity, identify(run)
        changed: dict[str, str] = {}
        for kind in ("sha256", "modules"):
            changed |= identity_differences(then.get(kind), now[kind], kind)
        if changed:
            why = "; ".join(changed.values())
            raise BtManipError(f"{self.recording.path} cannot be continued: {why}")
        lines, plugins = [], now.get("plugins", {})
        pairs = (versions(), then["versions"]), (plugins, then.get("plugins", plugins))
        for here, recorded in pairs:
            for name in sorted({*here, *recorded}):
                if here.get(name) != recorded.get(name):
                    others = f"{recorded.get(name, 'no version')}, here {here.get(name, 'none')}"
                    lines.append(f"recorded with {name} {others}: the run may go on differently")
        return lines

    def simulate(self, run: Run) -> dict[str, Any]:
        """Repeat a run from the last snapshot, and return the snapshot at the moment.

        Args:
            run: The run, prepared by the same request; its state afterwards is undefined.

        Raises:
            BtManipError: If the snapshot does not fit.
        """
        recorder = Recorder("", run.request.seed)
        restore_snapshot(self.recording.path, self._snapshot, run, recorder)
        if run.station.cell.time > self.time - 0.5 * run.station.cell.dt:
            return dict(self._snapshot)
        found: list[dict[str, Any]] = []
        observers = (recorder, self.interventions)
        run.execute([*observers, SnapshotAt(self.time, found.append)], stop=lambda: bool(found))
        if not found:
            raise BtManipError(f"{self.recording.path}: the run ends before {self.time:g} s")
        return found[0]


def _module_file(name: str, *folders: str) -> Path | None:
    """Return the file of a module, None without one; nothing is imported."""
    spec, places = None, [*folders, *sys.path]
    parts = name.split(".")
    for i in range(len(parts)):
        spec = PathFinder.find_spec(".".join(parts[: i + 1]), places)
        if spec is None:
            return None
        places = list(spec.submodule_search_locations or ())
    return Path(spec.origin) if spec is not None and spec.has_location and spec.origin else None
