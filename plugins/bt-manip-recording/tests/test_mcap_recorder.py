"""A recording holds the run, for Foxglove and for programs, and leaves the run as it is."""

import itertools
import json
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime
from io import BytesIO
from pathlib import Path
from time import sleep
from unittest.mock import Mock

import mujoco
import numpy as np
import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from bt_manip.bt import AlwaysFailure, Sequence, Sleep
from bt_manip.exceptions import BtManipError
from bt_manip.record import Recorder, RecordingError
from bt_manip.runner import RunObserver
from bt_manip.scenes import two_arms
from bt_manip_recording import (
    McapRecorder,
    Recording,
    mcap_file,
    mcap_recorder,
    read_trace,
    write_npz,
)
from bt_manip_recording.foxglove import SceneMessages
from bt_manip_recording.mcap_file import BlockWriter, McapFile
from tests.support.recorded import coming_and_going
from tests.support.runs import Listener


class Watch(RunObserver):
    """Keep what the recording should hold."""

    def run_started(self, run):
        self.station = run.station
        self.steps, self.poses, self.wrenches, self.free = [], [], [], []

    def after_step(self):
        self.free.append(self.station.cell.contact_monitor.summary().free)
        robot, arm = self.station.robot, self.station.arm
        tau = self.station.controller.tau.copy()
        state = (robot.q, robot.v, arm.q.copy(), arm.v.copy(), arm.a.copy(), tau)
        self.steps.append((self.station.cell.time, np.array(state)))

    def after_tick(self):
        cell = self.station.cell
        hand = cell.data.body("panda/hand")
        self.poses.append((cell.time, hand.xpos.copy(), hand.xquat.copy()))
        self.wrenches.append(self.station.robot.wrist_wrench())


@pytest.fixture(scope="module")
def recorded(make_run, tmp_path_factory):
    """Record a run once: the file, and what an observer saw."""
    path = tmp_path_factory.mktemp("recorded") / "run.mcap"
    watch, recorder = Watch(), Recorder("test", 7)
    make_run(coming_and_going(rest=1000), seed=7).execute([watch, recorder, McapRecorder(path)])
    watch.digest = recorder.report().state_digest
    return path, watch


def read(path: Path, *topics: str):
    """Read a file by the library's own reader."""
    with path.open("rb") as file:
        yield from make_reader(file, validate_crcs=True).iter_messages(topics or None)


def test_every_control_step_is_recorded_bit_for_bit(recorded):
    path, watch = recorded
    found = list(read(path, "/robots/panda/joints"))
    assert len(found) == len(watch.steps) > 500
    schema = found[0][0]
    assert (schema.name, schema.encoding) == ("bt_manip.ControlStep", "protobuf")
    # The file itself says how its messages are to be read.
    files = descriptor_pb2.FileDescriptorSet.FromString(schema.data)
    pool = descriptor_pool.DescriptorPool()
    for file in files.file:
        pool.Add(file)
    step_class = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))
    for (_, _, message), (time, state) in zip(found, watch.steps, strict=True):
        step = step_class.FromString(message.data)
        fields = [step.q, step.v, step.q_ref, step.v_ref, step.a_ref, step.tau]
        np.testing.assert_array_equal(np.array(fields), state)
        assert message.log_time == message.publish_time == round(time * 1e9)
    assert json.loads(found[0][1].metadata["joints"]) == [f"joint{i}" for i in range(1, 8)]


def test_geometry_comes_once_for_each_entity_and_goes_with_it(recorded):
    path, _ = recorded
    updates: dict[str, list[SceneUpdate]] = {}
    for schema, channel, message in read(path):
        if channel.topic.startswith("/scene/"):
            assert schema.name == "foxglove.SceneUpdate"
            updates.setdefault(channel.topic, []).append(SceneUpdate.FromString(message.data))
    assert updates.keys() >= {"/scene/world", "/scene/table", "/scene/panda", "/scene/cube"}
    assert len(updates["/scene/panda"]) == 1  # although the cell was compiled twice since
    added, removed = updates["/scene/cube"]
    (cube,) = added.entities
    assert cube.frame_locked and cube.frame_id == "cube/cube"
    assert len(cube.cubes) + len(cube.triangles) >= 1
    assert [d.type for d in removed.deletions] == [removed.deletions[0].ALL]
    links = {entity.frame_id: entity for entity in updates["/scene/panda"][0].entities}
    assert sum(len(t.indices) for t in links["panda/link1"].triangles) > 300


def test_the_wrench_is_that_of_the_robot(recorded):
    path, watch = recorded
    found = [json.loads(m.data) for _, _, m in read(path, "/robots/panda/state")]
    assert len(found) == len(watch.wrenches)
    for state, wrench in zip(found, watch.wrenches, strict=True):
        np.testing.assert_allclose(state["force"], wrench.force, rtol=1e-5, atol=1e-9)
        np.testing.assert_allclose(state["torque"], wrench.torque, rtol=1e-5, atol=1e-9)
        assert len(state["grip_forces"]) == 2 and isinstance(state["held"], list)


def test_the_log_tells_people_what_happened(make_run, recorded, tmp_path):
    make_run(Sequence("root", AlwaysFailure("never"))).execute([McapRecorder(tmp_path / "a.mcap")])
    for path, expected in (
        (recorded[0], {"cycle 1 started", "cube added", "cycle 1 succeeded"}),
        (tmp_path / "a.mcap", {"cycle 1 started"}),
    ):
        logs = [Log.FromString(message.data) for _, _, message in read(path, "/log")]
        assert expected <= {log.message for log in logs if log.level == Log.INFO}
        assert all(log.timestamp.ToNanoseconds() >= 0 for log in logs)
    (failed,) = [log.message for log in logs if log.level == Log.ERROR]
    assert failed.startswith("cycle 1 failed: never")


def test_metadata_identify_the_run_as_the_report_does_and_have_its_date(make_run, tmp_path):
    path, before = tmp_path / "run.mcap", datetime.now(UTC).replace(microsecond=0)
    recorder = Recorder("test", 7)
    run = make_run(Sleep(msec=20), seed=7, settings={"a": "1"})
    run.execute([recorder, McapRecorder(path)])
    report, recording = json.loads(recorder.report().to_json()), Recording(path)
    identity = recording.identity
    assert identity["seed"] == 7 and identity["settings"] == {"a": "1"}
    assert identity == {key: report[key] for key in identity}
    assert before <= datetime.fromisoformat(recording.date) <= datetime.now(UTC)


def test_the_planned_path_of_the_tool_is_drawn_while_the_arm_moves(recorded):
    path, watch = recorded
    updates = [
        (schema.name, SceneUpdate.FromString(message.data), message.log_time / 1e9)
        for schema, _, message in read(path, "/motions/panda")
    ]
    (name, drawn, start), (_, removed, end) = updates
    assert name == "foxglove.SceneUpdate"
    ((line,),) = (entity.lines for entity in drawn.entities)
    points = np.array([(p.x, p.y, p.z) for p in line.points])
    # The tool of the Panda is 0.1034 m in front of its hand.
    for at, point in ((start, points[0]), (end, points[-1])):
        _, position, quat = min(watch.poses, key=lambda pose: abs(pose[0] - at))
        lever = np.empty(3)
        mujoco.mju_rotVecQuat(lever, np.array([0.0, 0.0, 0.1034]), quat)
        np.testing.assert_allclose(point, position + lever, atol=2e-3)
    assert [one.type for one in removed.deletions] == [SceneEntityDeletion.ALL]


def test_the_same_run_on_another_date_gives_the_same_messages(
    make_run, recorded, tmp_path, monkeypatch
):
    monkeypatch.setattr(mcap_recorder, "datetime", Mock(now=lambda tz: datetime(2024, 3, 1)))
    make_run(coming_and_going(rest=1000), seed=7).execute([McapRecorder(tmp_path / "again.mcap")])
    contents = []
    for path in (recorded[0], tmp_path / "again.mcap"):
        contents.append({})
        for _, channel, message in read(path):
            # Where a slow run writes a chunk early, topics are mixed in another way.
            of_topic = contents[-1].setdefault(channel.topic, [])
            of_topic.append((message.log_time, message.sequence, message.data))
    assert contents[0] == contents[1]


def test_several_robots_have_topics_of_their_own(make_run, tmp_path):
    path = tmp_path / "two.mcap"
    make_run(Sleep(msec=30), scene=two_arms()).execute([McapRecorder(path)])
    recording = Recording(path)
    assert set(recording.joints) == {"left", "right"}
    left, right = recording.control_steps("left"), recording.control_steps("right")
    assert left["q"].shape == right["q"].shape == (40, 7)
    with pytest.raises(BtManipError, match="has the robots left, right"):
        recording.control_steps()
    write_npz(recording, tmp_path / "two.npz")
    np.testing.assert_array_equal(read_trace(tmp_path / "two.npz")["right/q"], right["q"])


def test_the_layout_opens_topics_that_are_in_the_file(recorded):
    path, _ = recorded
    layout = json.loads(path.with_suffix(".layout.json").read_text())
    topics = Recording(path).topics
    panels = layout["configById"]
    paths = [series["value"] for p in panels.values() for series in p.get("paths", [])]
    assert len(paths) > 20
    for value in paths:
        assert value.split(".")[0].split("{")[0] in topics
    assert set(panels["3D!scene"]["topics"]) == {
        t for t in topics if t.startswith(("/scene/", "/motions/"))
    }

    def shown(node):
        return {node} if isinstance(node, str) else shown(node["first"]) | shown(node["second"])

    assert shown(layout["layout"]) == panels.keys()


def test_a_layout_that_cannot_be_written_does_not_end_the_run(make_run, tmp_path):
    (tmp_path / "run.layout.json").mkdir()
    make_run(Sleep(msec=20)).execute([McapRecorder(tmp_path / "run.mcap")])
    assert Recording(tmp_path / "run.mcap").complete


def test_blocks_of_messages_are_written_as_the_librarys_writer_writes_them_one_by_one():
    times = [5, 3, 9, 9, 12, 1]
    data = [bytes([t]) * 40 for t in times]
    expected, found = BytesIO(), BytesIO()
    library, ours = (
        Writer(expected, 1 << 30, CompressionType.LZ4),
        BlockWriter(found, 1 << 30, CompressionType.LZ4),
    )
    for writer in (library, ours):
        writer.start("", "bt-manip")
        writer.add_metadata("run", {"seed": "7"})
        schema = writer.register_schema("s", "jsonschema", b"{}")
        for topic in ("a", "b"):
            channel = writer.register_channel(topic, "json", schema, {"joints": "[]"})
            if writer is ours:
                ours.add_messages(channel, times[:1], data[:1], [0])
                ours.add_messages(channel, times[1:], data[1:], [7, 8, 9, 9, 9])
            else:
                for time, content, number in zip(times, data, [0, 7, 8, 9, 9, 9], strict=True):
                    library.add_message(channel, time, content, time, number)
            writer.flush()
        writer.finish()
    assert found.getvalue() == expected.getvalue()


def test_a_chunk_has_the_messages_of_a_second(tmp_path, monkeypatch):
    monkeypatch.setattr(mcap_file, "FLUSH_INTERVAL", 1e3)  # not by time on the wall
    with closing(McapFile(tmp_path / "ticks.mcap", lambda: None)) as file:
        for time in range(0, 25 * 10**8, 10**7):
            file.add_json("/ticks", time, {})
            file.end_tick(time)
    with (tmp_path / "ticks.mcap").open("rb") as read_again:
        chunks = make_reader(read_again).get_summary().chunk_indexes
    assert [chunk.message_end_time for chunk in chunks] == [10**9, 2 * 10**9, 249 * 10**7]


def test_a_full_disk_is_an_error_at_the_end_of_the_run_and_a_missing_folder_before(
    make_run, tmp_path
):
    with pytest.raises(BtManipError, match="'.*/missing/run.mcap' cannot be written"):
        make_run(Sleep(msec=20)).execute([McapRecorder(tmp_path / "missing" / "run.mcap")])
    run, events = make_run(Sleep("rest", msec=1500)), []
    with pytest.raises(RecordingError, match="'/dev/full' cannot be written: No space left"):
        run.execute([Listener(events, McapRecorder.kinds), McapRecorder(Path("/dev/full"))])
    assert events[-1].data["status"] == "SUCCESS"
    assert not Path("/dev/full.layout.json").exists()


def test_a_file_cut_at_any_byte_opens_up_to_its_last_complete_chunk(recorded, tmp_path):
    path, _ = recorded
    data = path.read_bytes()
    with path.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    ends = [chunk.chunk_start_offset + chunk.chunk_length for chunk in chunks]
    assert len(ends) >= 2
    cut = tmp_path / "cut.mcap"
    everything = [(t, topic, d) for t, topic, d in Recording(path).messages()]
    near = {end + offset for end in ends for offset in (-1, 0, 1, 8, 9, 10)}
    random = np.random.default_rng(0).integers(8, len(data), 60).tolist()
    seen = set()
    for length in sorted({*near, *random, 8, 9, 17, len(data) - 1}):
        cut.write_bytes(data[:length])
        recording = Recording(cut)
        assert not recording.complete
        found = list(recording.messages())
        complete = sum(end <= length for end in ends)
        assert (len(found) > 0) == (complete > 0)
        assert found == everything[: len(found)]
        seen.add((complete, len(found)))
    # The number of messages depends on nothing but the number of complete chunks.
    assert len(seen) == len({complete for complete, _ in seen}) == len(ends) + 1
    assert max(seen) == (len(ends), len(everything))


def test_a_complete_recording_says_so_and_knows_contacts_limits_and_topics(recorded):
    path, watch = recorded
    recording = Recording(path)
    assert recording.complete
    assert recording.end == pytest.approx(watch.steps[-1][0])
    np.testing.assert_array_equal(recording.control_steps()["free"], watch.free)
    for name, limits in vars(watch.station.robot.limits).items():
        np.testing.assert_array_equal(getattr(recording.limits["panda"], name), limits)
    with pytest.raises(BtManipError, match="no topic '/tree/statu'.*'/tree/status'"):
        next(recording.messages("/tree/statu"))


TELL = """
from bt_manip.bt import Action, Status


class Tell(Action):
    def setup(self, *, cell, **_):
        self.cell = cell

    def update(self):
        print(self.cell.time, flush=True)
        return Status.RUNNING
"""


def test_a_killed_run_loses_at_most_a_second(tmp_path):
    path, run = tmp_path / "run.mcap", [sys.executable, "-m", "bt_manip", "run", "tell.py:Tell"]
    (tmp_path / "tell.py").write_text(TELL)
    options = "--record", path, "--real-time", "0.2", "--quiet"
    process = subprocess.Popen([*run, *options], cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    last = [float(line) for line in itertools.islice(process.stdout, 46)][-1]
    process.kill()
    process.wait()
    recording = Recording(path)
    assert not recording.complete
    assert recording.end >= last - 0.2
    assert recording.identity["tree"] == "tell.py:Tell"
    assert next(recording.messages("/tree/nodes"))[2]["nodes"][0]["name"] == "Tell"


def test_no_pose_is_lost_when_a_chunk_is_written_meanwhile(make_run, tmp_path, monkeypatch):
    copy = SceneMessages.copy_poses

    def copy_while_another_thread_writes(scene):
        sleep(0.02)
        return copy(scene)

    monkeypatch.setattr(mcap_file, "FLUSH_INTERVAL", 1e-3)
    monkeypatch.setattr(SceneMessages, "copy_poses", copy_while_another_thread_writes)
    recorder = McapRecorder(tmp_path / "run.mcap")
    make_run(Sleep(msec=50)).execute([recorder])
    assert len(list(Recording(tmp_path / "run.mcap").messages("/tf"))) == 7


def test_frames_have_their_times_and_poses_at_whole_seconds_too(make_run):
    cell = make_run(Sleep(msec=1)).station.cell
    scene = SceneMessages(cell.model, cell.data)
    times = [0, 10**7, 5 * 10**8, 10**9, 2 * 10**9, 2 * 10**9 + 10**7, 300 * 10**9]
    poses = [scene.copy_poses() for _ in times]
    rows = scene.movable_frames(times, poses)
    found = [FrameTransforms.FromString(row.tobytes()) for row in rows]
    hand = cell.data.body("panda/hand").xpos
    for time, message in zip(times, found, strict=True):
        stamps = {(one.timestamp.seconds, one.timestamp.nanos) for one in message.transforms}
        assert stamps == {divmod(time, 10**9)}
        assert {one.parent_frame_id for one in message.transforms} == {"world"}
        (one,) = (one for one in message.transforms if one.child_frame_id == "panda/hand")
        assert [one.translation.x, one.translation.y, one.translation.z] == hand.tolist()


@pytest.mark.parametrize(("joint", "moving"), [("<freejoint/>", ["ball"]), ("", [])])
def test_every_body_but_the_world_has_a_frame_in_one_of_both_messages(joint, moving):
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="post"><geom size=".1"/></body><body name="ball">'
        f'{joint}<geom size=".1"/></body><body name="sign"><geom size=".1"/></body></worldbody>'
        "</mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    scene = SceneMessages(model, data)
    (movable,) = scene.movable_frames([0], [scene.copy_poses()])
    frames = [
        [one.child_frame_id for one in FrameTransforms.FromString(message).transforms]
        for message in (movable.tobytes(), scene.fixed_frames(0))
    ]
    assert frames == [moving, [name for name in ("post", "ball", "sign") if name not in moving]]


def test_plugins_add_messages_of_their_own_after_each_tick(make_run, tmp_path):
    path, run = tmp_path / "run.mcap", make_run(Sleep(msec=30))

    def make(of, add):
        assert of is run

        def write():
            add("/mine", {"time": of.station.cell.time})
            add("/note", Log(message="tick"))

        return write

    parts = run.station.parts
    sources = parts.of("message_sources").with_part("mine", make)
    declared = {**parts.declared, "message_sources": sources}
    run.station = replace(run.station, parts=replace(parts, declared=declared))
    run.execute([McapRecorder(path)])
    mine = [(json.loads(m.data)["time"], m.log_time / 1e9) for _, _, m in read(path, "/mine")]
    assert [time for time, _ in mine] == pytest.approx([0.01, 0.02, 0.03, 0.04])
    assert all(time == pytest.approx(logged) for time, logged in mine)
    notes = [Log.FromString(m.data).message for _, _, m in read(path, "/note")]
    assert notes == ["tick"] * len(mine)


def test_a_recorded_run_keeps_its_digest(make_run, recorded):
    recorder = Recorder("test", 7)
    make_run(coming_and_going(rest=1000), seed=7).execute([recorder])
    assert recorder.report().state_digest == recorded[1].digest
