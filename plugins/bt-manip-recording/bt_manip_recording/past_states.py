"""Recording of the states of a run after the fact."""

from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms

from bt_manip.runner import Run, RunEvent
from bt_manip_recording.foxglove import add_scene, cameras_of, frame_messages
from bt_manip_recording.mcap_file import McapFile
from bt_manip_recording.mcap_recorder import (
    CAMERAS,
    add_event,
    add_joints,
    describe_run,
    nanoseconds,
)
from bt_manip_recording.protobuf import FREE, control_step_template
from bt_manip_recording.visuals import SceneSource

BLOCK = 100
"""Number of states that are encoded at once."""


class States(SceneSource, Protocol):
    """The states of a run between its ticks; as a scene, it shows that of number `index`."""

    first: int
    """Number of the first state."""
    last: int
    """Number of the last state."""
    index: int
    """Number of the state that the scene shows."""

    @property
    def time(self) -> float:
        """Simulated time of that state [s]."""

    def events(self, before: int, index: int) -> Sequence[RunEvent]:
        """Return the events that lead from a state to a later one; all if ``before`` is -1."""

    def alike(self, first: int) -> int:
        """Return the number of states from one on in which the same things are in the cell."""

    def rows(
        self, first: int, end: int
    ) -> tuple[np.ndarray, Sequence[str], np.ndarray, Mapping[str, tuple[np.ndarray, list[bool]]]]:
        """Return times [s], frames, their poses, and the last control step of each robot.

        A step has the fields of `bt_manip.runner.STEP_FIELDS`, the tool's position [m], and whether
        grippers and what they hold touched only each other; state 0 is left out of the steps.
        """  # (n,), n_frames names, (n, n_frames, 7), (n, 6 nq + 3) and n each


def record_states(run: Run, states: States, path: Path) -> None:
    """Write the states of a run as a recording.

    It has scene, events, and the poses and the control step at the end of each tick. Forces, other
    control steps, and snapshots to continue from are only in a recording made during the run.

    Args:
        run: The run.
        states: Its states.
        path: The file to write.

    Raises:
        RecordingError: If it cannot be written.
    """
    robots = run.station.robots
    with closing(McapFile(path, lambda: None)) as file:
        describe_run(file, run)
        topics = {name: add_joints(file, one) for name, one in robots.items()}
        templates = {n: control_step_template(len(r.robot.limits.lower)) for n, r in robots.items()}
        file.add("/tf_static", 0, FrameTransforms().SerializeToString())
        shown: Mapping[str, Any] = {}
        start = states.first
        while start <= states.last:
            end = start + min(BLOCK, states.alike(start))
            states.index = start
            file.sequence = start - states.first
            before, time = shown, nanoseconds(states.time)
            shown = add_scene(file, states, before, time)
            if shown != before:
                file.add_json(CAMERAS, time, cameras_of(states))
            for number in range(start, end):
                file.sequence = number - states.first
                for event in states.events(number - 1, number):
                    add_event(file, event)
            times, frames, poses, steps = states.rows(start, end)
            ticks = [nanoseconds(time) for time in times.tolist()]
            parts = [part.reshape(len(ticks), -1) for part in np.split(poses, [3], axis=2)]
            sequences = range(start - states.first, end - states.first)
            messages = frame_messages(tuple(frames), ticks, np.hstack(parts))
            file.add_all("/tf", times, messages, sequences)
            for name, (rows, free) in steps.items():
                messages = templates[name].serialize(rows)
                messages[:, FREE] = free
                file.add_all(topics[name], times[len(times) - len(rows) :], messages)
            file.end_tick(ticks[-1])
            start = end
