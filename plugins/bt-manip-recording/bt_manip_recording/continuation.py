"""Continuing a recorded run from any of its moments."""

from collections.abc import Mapping
from typing import Any

from bt_manip.exceptions import BtManipError
from bt_manip.record import Recorder, SnapshotAt, identify, restore_snapshot, versions
from bt_manip.runner import Run, RunModifier, RunRequest, find_tree
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

    Attributes:
        recording: The recording.
        time: Simulated time of the moment [s].
        fields: The request of the run, as plain data.

    Raises:
        BtManipError: If there is none, or the run cannot be continued.
    """

    def __init__(self, recording: Recording, time: float) -> None:
        self.recording, self.time = recording, time
        where = recording.path
        for key, option in (("faults", "--fault"), ("varied", "--vary")):
            if recording.identity.get(key):
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
            self.fields: Mapping[str, Any] = self._snapshot["request"]

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
            BtManipError: If the tree is not there.
        """
        fields = dict(self.fields)
        return RunRequest(find_tree(fields.pop("tree"), trees), **fields, **others)

    def differences(self, run: Run) -> list[str]:
        """Return the differences from the installation that recorded the run, as warnings.

        Args:
            run: The run, prepared by the same request.

        Raises:
            BtManipError: If a file of tree, scene or robot has changed since.
        """
        then, now = self.recording.identity, identify(run)
        files = {**then["sha256"], **now["sha256"]}
        changed = [f for f in files if then["sha256"].get(f) != now["sha256"].get(f)]
        if changed:
            raise BtManipError(
                f"{self.recording.path} cannot be continued: the {' and the '.join(changed)} "
                "changed since it was recorded (SHA-256)"
            )
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
