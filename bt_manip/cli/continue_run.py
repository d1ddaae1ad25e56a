"""``bt-manip replay --continue``: simulate on from a moment of a recorded run."""

from dataclasses import replace
from pathlib import Path

from bt_manip.cli.foreign_trees import ForeignTrees
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.page_session import execute_run
from bt_manip.cli.run_options import RunOptions

REQUEST = ("tree", "cycles", "seed", "robot", "controller", "scene", "planner", "settings")
"""Fields of a recorded request that are options, too."""


def continue_run(path: Path, time: float, interrupt: Interrupt, options: RunOptions) -> int:
    """Simulate a recorded run again up to a time, then run on as ``bt-manip run`` does.

    Args:
        path: The recording.
        time: Simulated time [s].
        interrupt: Ctrl-C.
        options: How the run is watched; the others are those of the recording.

    Returns:
        The exit code.

    Raises:
        BtManipError: If the run cannot be continued from there.
    """
    from bt_manip.record import Continuation, Recording

    continued = Continuation(Recording(path), time)
    fields, identity = continued.fields, continued.recording.identity
    with continued.recording.decoding():
        options = replace(
            options,
            **{key: fields[key] for key in REQUEST},
            tick_ms=1e3 * fields["tick"],
            foreign=ForeignTrees.of(identity.get("foreign", {})),
            continued=continued,
        )
    return execute_run(options, interrupt)
