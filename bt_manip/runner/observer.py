"""The interface of recorders and views of a run."""

from typing import Any

from bt_manip.registry import Registry


class RunObserver:
    """Observes a run without changing it; the methods of this base class do nothing.

    The runner calls, in this order::

      check(run)
      run_started(run)
        cycle_started(cycle)
          [ before_tick(), tree tick, tick/dt x { control step, after_step() }, after_tick() ] ...
        cycle_ended(status, reason)
      run_ended()

    `after_compile` is called once before the first `cycle_started`, and before the next step
    whenever the cell has been recompiled: ids and views of the physics must be renewed there.
    `before_tick` and `after_step` are only called where a subclass overrides them. If a run is
    interrupted or an exception is raised, moving arms are stopped first (`after_step` and
    `after_tick` continue, without ticks) and `run_ended` is called, but `cycle_ended` is not.
    """

    def check(self, run: Any) -> None:
        """Check that the run can be observed; it may be called before `Run.execute`, too.

        Raises:
            BtManipError: If not.
        """

    def run_started(self, run: Any) -> None:
        """Prepare for a run; it has `.request`, `.station` and `.tree`."""

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

    def cycle_ended(self, status: str, reason: str) -> None:
        """Observe the end of a cycle.

        Args:
            status: ``"SUCCESS"`` or ``"FAILURE"``; a cycle whose goal does not hold has failed.
            reason: Reason of a failure: the path of the node, or the goal; empty on success.
        """

    def run_ended(self) -> None:
        """Close files and windows; called once, however the run ends."""


def recorder_suffixes(recorders: Registry[Any]) -> dict[str, str]:
    """Return the names of recorders by the suffixes of the files that they write."""
    names: dict[str, str] = {}
    for name in recorders:
        known = getattr(recorders.get(name), "suffix", ())
        names |= dict.fromkeys([known] if isinstance(known, str) else known, name)
    return names
