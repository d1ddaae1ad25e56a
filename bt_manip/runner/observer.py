"""The interface of recorders and views of a run."""

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_manip.exceptions import BtManipError
from bt_manip.packages import missing
from bt_manip.registry import Registry

if TYPE_CHECKING:
    from .events import RunEvent
    from .run import Run


class RunObserver:
    """Observes a run without changing it; the methods of this base class do nothing.

    The loop calls, in this order::

      check(run)
      run_started(run)
        cycle_started(cycle)
          [ before_tick(), tick, tick/dt x { control step, after_step() }, after_tick() ] ...
        cycle_ended(status, reason)
      run_ended()

    `after_compile` is called once before the first `cycle_started`, and before the next step
    whenever the cell has been recompiled: ids and views of the physics must be renewed there.
    `after_step` is only called where a subclass overrides it. `handle` is called with the events of
    the wanted kinds: those of a tick before its `after_tick`. If a run is interrupted or an
    exception is raised, moving arms are stopped first (`after_step` and `after_tick` continue,
    without ticks) and `run_ended` is called, but `cycle_ended` is not.

    Attributes:
        kinds: Kinds of the events that `handle` wants, as in `RunEvent`; read when a run starts.
    """

    kinds: Collection[str] = ()

    def check(self, run: "Run") -> None:
        """Check that the run can be observed; it may be called before `Run.execute`, too.

        Raises:
            BtManipError: If not.
        """

    def run_started(self, run: "Run") -> None:
        """Prepare for a run; it has `.request`, `.station`, `.tree` and `.log`.

        Observers that are added to the tree here are removed when the run has ended.
        """

    def after_compile(self) -> None:
        """Renew ids and views of the compiled model."""

    def cycle_started(self, cycle: int) -> None:
        """Observe the beginning of a cycle, counted from 0."""

    def before_tick(self) -> None:
        """Observe the state before a tick."""

    def after_step(self) -> None:
        """Observe the state after a control step, in about 2 us."""

    def after_tick(self) -> None:
        """Observe the state after a tick and its control steps."""

    def handle(self, event: "RunEvent") -> None:
        """Take an event of one of the wanted kinds."""

    def cycle_ended(self, status: str, reason: str) -> None:
        """Observe the end of a cycle.

        Args:
            status: ``"SUCCESS"`` or ``"FAILURE"``; a cycle whose goal does not hold has failed.
            reason: Reason of a failure: the path of the node, or the goal; empty on success.
        """

    def run_ended(self) -> None:
        """Close files and windows; called once, however the run ends."""


class RunView(RunObserver):
    """Shows runs, one or several one after the other; made before the first of them."""

    def close(self) -> None:
        """Release the resources of a view that outlives its run."""


class RunModifier(RunObserver):
    """Changes a run between two ticks: injected faults, an edited tree, repeated interventions.

    The loop calls modifiers after all observers: these see a tick as it begins, and judge a cycle
    before a modifier undoes what it did in it.
    """

    @property
    def missed(self) -> Sequence[str]:
        """What it was to change in the present cycle, or the last one, and has not changed.

        Words for messages: ``"fault 'heavy at=Lift'"``.
        """
        return ()


def recorder_for(path: Path, recorders: Registry[Any]) -> RunObserver:
    """Return the recorder of a file's suffix.

    Raises:
        BtManipError: If there is none, or it cannot write the file.
    """
    return recorders.create(recorder_name(path.suffix, recorders), path)


def recorder_name(suffix: str, recorders: Registry[Any]) -> str:
    """Return the name of the recorder whose files have a suffix; raise if there is none."""
    names: dict[str, str] = {}
    for name in recorders:
        known = getattr(recorders.get(name), "suffix", ())
        names |= dict.fromkeys([known] if isinstance(known, str) else known, name)
    if suffix not in names:
        known = ", ".join(sorted(names))
        package = missing("file", suffix)
        hint = f"; {suffix} {package}" if package else f", known are {known or 'none'}"
        raise BtManipError(f"no recorder writes '{suffix}' files{hint}")
    return names[suffix]
