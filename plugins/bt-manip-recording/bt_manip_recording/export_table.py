"""The control steps of a recording as a table, CSV or Apache Parquet, and as a trace."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from bt_manip.bt import NodeKind
from bt_manip.cell import WORLD, entity_of
from bt_manip.record import whole_file, writing
from bt_manip.runner import STEP_FIELDS
from bt_manip_recording.recorded_run import running_leaves
from bt_manip_recording.recorded_scene import RecordedScene
from bt_manip_recording.recording import Recording
from bt_manip_recording.trace import write_trace

POSE_COLUMNS = ("x", "y", "z", "qw", "qx", "qy", "qz")
"""Columns of a pose: position [m] and quaternion in the world."""

WRENCH = ("force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z")
"""Columns of the wrench on a gripper in its tool frame [N, N m]."""

SEPARATOR = "; "
"""Between several names in one cell of the table."""


def control_step_table(recording: Recording) -> dict[str, Any]:
    """Return the control steps of a recording, one row each, as columns by name.

    They are those of ``docs/recordings.md``: time, joints of each robot, wrench and grip, poses
    of objects, running leaves. The state of grippers and objects is that after the last tick so
    far; NaN where there is none.

    Raises:
        BtManipError: If the recording has no control steps.
    """
    columns: dict[str, Any] = {}
    blocks = recording.step_blocks()
    columns["t"] = t = next(iter(blocks.values())).t
    for robot, joints in recording.joints.items():
        for i, joint in enumerate(joints):
            for name in STEP_FIELDS:
                columns[f"{robot}/{joint}/{name}"] = getattr(blocks[robot], name)[:, i]
        columns |= _robot_columns(recording, robot, t)
    columns |= _object_columns(RecordedScene(recording), set(recording.joints), t)
    running = running_leaves(recording, t)
    columns["node"] = [SEPARATOR.join(leaf.path for leaf in leaves) for leaves in running]
    columns["phase"] = [
        SEPARATOR.join(leaf.name for leaf in leaves if leaf.kind == NodeKind.ACTION)
        for leaves in running
    ]
    return columns


def write_csv(recording: Recording, path: Path) -> None:
    """Write the control steps of a recording as CSV, with a header.

    Raises:
        BtManipError: If the recording has none.
    """
    from pyarrow import csv

    _write(recording, path, csv.write_csv)


def write_parquet(recording: Recording, path: Path) -> None:
    """Write the control steps of a recording as Parquet; its metadata identify the run.

    Raises:
        BtManipError: If the recording has none.
    """
    from pyarrow import parquet

    _write(recording, path, parquet.write_table)


def write_npz(recording: Recording, path: Path) -> None:
    """Write the control steps of a recording as the trace of its run.

    Raises:
        BtManipError: If the recording has none.
    """
    write_trace(path, recording.step_blocks(), recording.joints)


def _write(recording: Recording, path: Path, write: Callable[[Any, BinaryIO], None]) -> None:
    import pyarrow

    with recording.decoding():
        columns = {
            name: pyarrow.array(column, from_pandas=True)  # NaN becomes null
            for name, column in control_step_table(recording).items()
        }
    identity = {"bt_manip": json.dumps(recording.identity)}
    table = pyarrow.table(columns).replace_schema_metadata(identity)
    with writing(path, "table"), whole_file(path) as file:
        write(table, file)


def _robot_columns(recording: Recording, robot: str, t: np.ndarray) -> dict[str, Any]:
    """Return the state of wrist and gripper after the last tick at some times."""
    topic = f"/robots/{robot}/state"  # missing where only the states of a page were saved
    found = list(recording.messages(topic)) if topic in recording.topics else []
    states = [state for _, _, state in found]
    rows = _latest([time for time, _, _ in found], t)
    wrench = np.array([[*state["force"], *state["torque"]] for state in states]).reshape(-1, 6)
    columns: dict[str, Any] = {
        f"{robot}/{name}": _rows_of(wrench[:, i], rows) for i, name in enumerate(WRENCH)
    }
    for i in range(max((len(state["grip_forces"]) for state in states), default=0)):
        forces = np.array([state["grip_forces"][i] for state in states])
        columns[f"{robot}/grip_force{i + 1}"] = _rows_of(forces, rows)
    held = [SEPARATOR.join(state["held"]) for state in states]
    columns[f"{robot}/held"] = [held[i] if i >= 0 else "" for i in rows.tolist()]
    for name in ("saturated_steps", "speed_scale"):
        column = np.array([state[name] for state in states], dtype=float)
        columns[f"{robot}/{name}"] = _rows_of(column, rows)
    return columns


def _object_columns(scene: RecordedScene, robots: set[str], t: np.ndarray) -> dict[str, Any]:
    """Return the poses of all entities but robots after the last tick at some times."""
    frames: dict[str, int] = {}  # the first body of each entity
    for i, frame in enumerate(scene.frames):
        if entity_of(frame) not in {WORLD, *robots}:
            frames.setdefault(entity_of(frame), i)
    poses = np.full((len(scene.times), len(frames), len(POSE_COLUMNS)), np.nan)
    for row, time in zip(poses, scene.times, strict=True):
        scene.seek(time)
        present, now = scene.entities(), scene.poses()
        for pose, (entity, i) in zip(row, frames.items(), strict=True):
            if entity in present:
                pose[:] = now[i]
    rows = _latest(scene.times, t)
    return {
        f"{entity}/{name}": _rows_of(poses[:, i, k], rows)
        for i, entity in enumerate(frames)
        for k, name in enumerate(POSE_COLUMNS)
    }


def _latest(times: Sequence[float] | np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return the index of the last time at or before each of others; -1 where there is none."""
    return np.searchsorted(np.asarray(times), t, side="right") - 1


def _rows_of(column: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return rows of a column; NaN for row -1."""
    return np.append(column, np.nan)[rows]
