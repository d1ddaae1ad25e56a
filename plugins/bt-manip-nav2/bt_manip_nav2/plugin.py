"""Hooks of this package."""

from collections.abc import Callable

from bt_manip import hookimpl


@hookimpl
def register_behaviours(register: Callable[..., None]) -> None:
    """Register the control nodes and decorators."""
    from bt_manip_nav2 import controls, decorators

    for cls in (
        controls.RecoveryNode,
        controls.PipelineSequence,
        controls.RoundRobin,
        controls.NonblockingSequence,
        controls.PersistentSequence,
        decorators.RateController,
        decorators.DistanceController,
        decorators.SpeedController,
        decorators.GoalUpdater,
        decorators.GoalUpdatedController,
        decorators.PathLongerOnApproach,
        decorators.SingleTrigger,
    ):
        register(cls)
