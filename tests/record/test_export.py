"""What is exported is what was recorded."""

import re
from pathlib import Path

import av
import numpy as np
import pytest
from bt_manip.record.video.export_video import SceneModel, frame_times
from mcap.reader import make_reader
from pyarrow import csv, parquet

from bt_manip.behaviours import MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import Node, Sequence, Sleep
from bt_manip.cell import FrameRenderer, camera_number
from bt_manip.exceptions import BtManipError
from bt_manip.record import (
    McapRecorder,
    RecordedScene,
    Recording,
    VideoRecorder,
    write_csv,
    write_mcap,
    write_parquet,
    write_video,
)
from bt_manip.runner import RunObserver


def coming_and_going() -> Node:
    return Sequence(
        "root",
        SpawnObject("come", object="{cube}"),
        MoveToConfiguration("turn", configuration=[1.0, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        Sleep("rest", msec=50),
        RemoveObject("go", object="{cube}"),
        Sleep("end", msec=50),
    )


class Cube(RunObserver):
    """Keeps time, running nodes and the position of the cube after each step and tick."""

    def run_started(self, run):
        self.cell, self.tree = run.station.cell, run.tree
        self.steps, self.ticks = [], []

    def after_step(self):
        running = [n.name for n in self.tree.nodes[1:] if n.engine_status.name == "RUNNING"]
        self.steps.append((self.cell.time, "; ".join(running)))

    def after_tick(self):
        present = "cube" in self.cell.entities
        position = self.cell.data.body("cube/cube").xpos.copy() if present else None
        self.ticks.append((self.cell.time, position))


@pytest.fixture(scope="module")
def recorded(make_run, tmp_path_factory):
    """Record a run once; give the recording, its folder and what was seen."""
    folder = tmp_path_factory.mktemp("recorded")
    cube = Cube()
    make_run(coming_and_going()).execute([cube, McapRecorder(folder / "run.mcap")])
    return Recording(folder / "run.mcap"), folder, cube


@pytest.fixture(scope="module")
def table(recorded):
    recording, folder, _ = recorded
    write_parquet(recording, folder / "run.parquet")
    return parquet.read_table(folder / "run.parquet")


def test_the_table_has_the_recorded_control_steps(recorded, table):
    recording, _, cube = recorded
    steps = recording.control_steps()
    assert table.num_rows == len(cube.steps) > 200
    assert table["t"].to_pylist() == steps["t"].tolist()
    for i, joint in enumerate(recording.joints["panda"]):
        for name in ("q", "v", "q_ref", "v_ref", "a_ref", "tau"):
            assert table[f"panda/{joint}/{name}"].to_pylist() == steps[name][:, i].tolist()


def test_objects_have_a_pose_while_they_are_there(recorded, table):
    _, _, cube = recorded
    columns = [table[f"cube/{axis}"].to_pylist() for axis in "xyz"]
    ends = np.array([time for time, _ in cube.ticks])
    seen = 0
    for i in range(0, table.num_rows, 7):
        tick = np.searchsorted(ends, cube.steps[i][0] + 1e-9) - 1
        expected = cube.ticks[tick][1] if tick >= 0 else None
        found = [column[i] for column in columns]
        if expected is None:
            assert found == [None] * 3
        else:
            assert found == expected.tolist()
            seen += 1
    assert 0 < seen < table.num_rows / 7 - 5


def test_the_running_leaf_and_its_phase_are_those_of_the_tick(recorded, table):
    _, _, cube = recorded
    assert [path.split("/")[-1] for path in table["node"].to_pylist()] == [n for _, n in cube.steps]
    phases = table["phase"].to_pylist()
    assert "turn" in phases and set(phases) <= {"turn", "rest", "end", ""}


def test_the_state_of_the_gripper_is_that_after_the_last_tick(recorded, table):
    recording, _, _ = recorded
    states = [(t, state) for t, _, state in recording.messages("/robots/panda/state")]
    time, state = states[len(states) // 2]
    row = table.slice(table["t"].to_pylist().index(time), 1).to_pylist()[0]
    assert [row[f"panda/force_{axis}"] for axis in "xyz"] == state["force"]
    assert [row[f"panda/torque_{axis}"] for axis in "xyz"] == state["torque"]
    assert [row[f"panda/grip_force{i}"] for i in (1, 2)] == state["grip_forces"]
    assert row["panda/speed_scale"] == 1.0 and row["panda/held"] == ""
    assert table["panda/force_x"][0].as_py() is None  # before the end of the first tick


def test_the_metadata_of_a_parquet_file_identify_the_run(table):
    assert b'"tree": "test"' in table.schema.metadata[b"bt_manip"]


def test_a_csv_file_has_the_same_table(recorded, table):
    recording, folder, _ = recorded
    write_csv(recording, folder / "run.csv")
    options = csv.ConvertOptions(column_types=table.schema.remove_metadata())
    read = csv.read_csv(folder / "run.csv", convert_options=options)
    assert read.column_names == table.column_names
    for name in table.column_names:
        assert read[name].to_pylist() == table[name].to_pylist()


def test_a_recording_without_control_steps_has_no_table(recorded, tmp_path):
    recording, _, _ = recorded
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.path.read_bytes()[:2000])
    with pytest.raises(BtManipError, match=r"cut.mcap has no control steps"):
        write_parquet(Recording(cut), tmp_path / "cut.parquet")
    assert [path.name for path in tmp_path.iterdir()] == ["cut.mcap"]


def test_a_cut_recording_becomes_a_complete_one(recorded, tmp_path):
    recording, _, _ = recorded
    cut, complete = tmp_path / "cut.mcap", tmp_path / "complete.mcap"
    with recording.path.open("rb") as file:
        last = make_reader(file).get_summary().chunk_indexes[-1]
    end = last.chunk_start_offset + last.chunk_length
    cut.write_bytes(recording.path.read_bytes()[: end + 100])
    whole = Recording(cut)
    assert not whole.complete
    write_mcap(whole, complete)
    assert Recording(complete).complete and Recording(complete).identity == recording.identity
    with complete.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None and summary.chunk_indexes  # not by scanning
        found = [
            (m.sequence, m.log_time / 1e9, channel.topic, m.data)
            for _, channel, m in reader.iter_messages()
        ]
        assert {schema.name for schema in summary.schemas.values()} >= {"foxglove.SceneUpdate"}
    raw = [(s, t, topic) for s, t, topic, _ in whole.numbered_messages()]
    assert sorted(row[:3] for row in found) == sorted(raw) and len(raw) > 500
    expected = [data for _, _, data in whole.messages("/tf")]
    assert [data for *_, topic, data in found if topic == "/tf"] == expected


def test_a_recording_may_be_replaced_by_its_complete_form(recorded, tmp_path):
    recording, _, _ = recorded
    path = tmp_path / "run.mcap"
    path.write_bytes(recording.path.read_bytes()[:-1000])
    write_mcap(Recording(path), path)
    assert Recording(path).complete and Recording(path).end == recording.end


@pytest.fixture(scope="module")
def videos(opengl, recorded, make_run):
    """Render the recording, and the same run while it goes on."""
    recording, folder, _ = recorded
    exported, live = folder / "exported.mp4", folder / "live.mp4"
    write_video(recording, exported, size="160x100", fps=4.0)
    make_run(coming_and_going()).execute([VideoRecorder(live, size="160x100", fps=4.0)])
    return exported, live


def frames_of(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Give the times of the frames and their images."""
    with av.open(path) as video:
        frames = list(video.decode(video=0))
    times = [float(frame.pts * frame.time_base) for frame in frames]
    return np.array(times), np.array([frame.to_ndarray(format="rgb24") for frame in frames])


def test_a_rendered_recording_looks_like_the_run(videos):
    (times, images), (live_times, live) = map(frames_of, videos)
    assert len(times) == len(live_times) >= 3
    np.testing.assert_allclose(times, live_times, rtol=0.0, atol=0.5e-3)
    difference = np.abs(images.astype(int) - live)
    assert difference.mean() < 6.0  # textures are their mean colours
    changed = np.abs(live[-1].astype(int) - live[0]).max(axis=2) > 40
    assert changed.mean() > 0.01 and difference[-1][changed].mean() < 20.0


def test_an_object_is_shown_only_while_it_is_there(recorded, opengl):
    recording, _, cube = recorded
    there = [time for time, position in cube.ticks if position is not None]
    scene = RecordedScene(recording)
    shown = SceneModel(scene)
    renderer = FrameRenderer(shown.model, 64, 48, shadow_size=0, samples=0)
    images, alphas = [], []
    for time in (0.0, there[0], cube.ticks[-1][0]):
        scene.seek(time)
        shown.update()
        images.append(renderer.frame(shown.data, camera_number(shown.model, "panda/wrist")))
        alphas.append((shown.model.geom_rgba[:, 3] > 0).sum())
    renderer.close()
    changed = np.abs(images[1].astype(int) - images[0]).max(axis=2) > 20
    assert 0.002 < changed.mean() < 0.1  # the arm has hardly moved
    assert alphas[0] == alphas[2] < alphas[1]


def test_frames_are_at_ticks(recorded):
    recording, _, _ = recorded
    scene = RecordedScene(recording)
    assert frame_times(scene.times, 400.0).tolist() == scene.times.tolist()
    times = frame_times(scene.times, 25.0)
    assert times[-1] <= scene.times[-1] < times[-1] + 0.04
    np.testing.assert_allclose(times, 0.04 * np.arange(len(times)))


def test_the_number_of_frames_is_limited_by_that_of_ticks():
    assert frame_times(np.array([0.0, 0.01, 1e10]), 25.0).tolist() == [0.0, 0.01, 1e10]


def test_an_unknown_camera_is_refused_with_the_nearest_name(recorded, tmp_path):
    with pytest.raises(BtManipError, match=re.escape("'panda/wirst'; did you mean 'panda/wrist'?")):
        write_video(recorded[0], tmp_path / "a.mp4", camera="panda/wirst")
    assert not list(tmp_path.iterdir())
