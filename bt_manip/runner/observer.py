"""What may watch a run: recorders and views."""

from typing import Any


class RunObserver:
    """Watches a run without changing it; every method here does nothing.

    The runner calls, in this order:

    ```
    run_started(run)
      cycle_started(cycle)
        [ before_tick(), tree tick, tick/dt times { control step, after_step() }, after_tick() ] ...
      cycle_ended(status, reason)
    run_ended()
    ```

    `after_compile` comes whenever the cell was compiled anew, before the next step, and once
    before the first `cycle_started`: what holds ids, views or handles of the physics binds them
    again there. An observer that leaves `before_tick` or `after_step` as it is here is never called
    for it. When a run is interrupted or something raises, `run_ended` is still called, and
    `cycle_ended` of the cycle that was under way is not. An arm that moves then is braked first:
    `after_step` and `after_tick` go on meanwhile, without ticks.
    """

    def run_started(self, run: Any) -> None:
        """Look at the run that is about to begin: `.request`, `.station` and `.tree`."""

    def after_compile(self) -> None:
        """Bind again what belongs to the compiled model."""

    def cycle_started(self, cycle: int) -> None:
        """Note the beginning of a cycle; the first has number 0."""

    def before_tick(self) -> None:
        """Note the state that the tree is about to be ticked in."""

    def after_step(self) -> None:
        """Note the state after one control step; there are some 2 us for it."""

    def after_tick(self) -> None:
        """Note the state after a tick of the tree and the control steps that belong to it."""

    def cycle_ended(self, status: str, reason: str) -> None:
        """Note how a cycle ended.

        Args:
            status: ``"SUCCESS"`` or ``"FAILURE"``.
            reason: Why it failed, with the path of the node; empty on success.
        """

    def run_ended(self) -> None:
        """Let go of what was held; called once however the run ends."""
