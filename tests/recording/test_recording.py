"""Recordings with any content are read or refused with one line."""

import json

import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from mcap.reader import make_reader
from mcap.writer import Writer

from bt_manip.exceptions import BtManipError
from bt_manip.recording import Continuation, RecordedRun, RecordedScene, Recording, Timeline
from bt_manip.recording.export_video import SceneModel
from bt_manip.recording.mcap_recorder import SNAPSHOTS
from bt_manip.recording.protobuf import control_step_class


def rewrite(source, target, topic, data, *, metadata=None):
    """Copy the first second of a recording, with other messages of a topic."""
    with source.open("rb") as file, target.open("wb") as out:
        reader, writer, channels = make_reader(file), Writer(out), {}
        writer.start()
        for one in reader.iter_metadata():
            writer.add_metadata(one.name, (metadata or {}).get(one.name, one.metadata))
        for _, channel, message in reader.iter_messages(ending_before=1_000_000_000):
            if channel.id not in channels:
                texts = channel.metadata
                if channel.topic == topic:
                    texts = (metadata or {}).get(topic, texts)
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, 0, texts
                )
            changed = data if channel.topic == topic and data is not None else message.data
            time = message.log_time
            writer.add_message(channels[channel.id], time, changed, time, message.sequence)
        writer.finish()
    return target


def show(recording):
    """Read whatever a report, a page and a video read."""
    RecordedRun(recording)
    Timeline(recording)
    scene = RecordedScene(recording)
    scene.poses()
    SceneModel(scene)


def triangle(*indices):
    update = SceneUpdate()
    body = update.entities.add(frame_id="table/table")
    body.triangles.add(indices=indices).points.add(x=1.0)
    return update.SerializeToString()


STEP = control_step_class()
JOINTS = "/robots/panda/joints"


def test_an_unchanged_copy_can_be_shown(picked, tmp_path):
    show(Recording(rewrite(picked, tmp_path / "run.mcap", "", None)))


@pytest.mark.parametrize(
    ("topic", "data"),
    [
        ("/tf", b"\xff"),
        ("/tree/status", b"{"),
        ("/tree/status", b'{"uid": 77777, "status": "RUNNING"}'),
        ("/tree/nodes", b"[]"),
        ("/contacts", b"1"),
        ("/cameras", b'{"cameras": [{}], "centre": [0, 0, 0], "extent": 1}'),
        ("/robots/panda/state", b"{}"),
        (JOINTS, b"\xff"),
        (JOINTS, b""),
        (JOINTS, STEP(q=[1.0] * 7).SerializeToString()),
        ("/scene/table", triangle(0, 0, 1)),
        ("/scene/table", triangle(0, 0, 4_000_000_000)),
        ("/scene/table", triangle(0, 0)),
    ],
)
def test_other_messages_than_those_of_the_recorder_are_refused(picked, tmp_path, topic, data):
    recording = Recording(rewrite(picked, tmp_path / "run.mcap", topic, data))
    with pytest.raises(BtManipError, match="run.mcap is damaged"):
        show(recording)


@pytest.mark.parametrize(
    "metadata",
    [
        {"run": {"tree": "{"}},
        {"tree": {}},
        {JOINTS: {"joints": '["a"]', "lower": "[0]", "size": "1"}},
        {JOINTS: {"joints": "no"}},
    ],
)
def test_other_metadata_than_those_of_the_recorder_are_refused(picked, tmp_path, metadata):
    path = rewrite(picked, tmp_path / "run.mcap", JOINTS, None, metadata=metadata)
    with pytest.raises(BtManipError, match="run.mcap is damaged"):
        Recording(path)


@pytest.mark.parametrize("data", [b"1", b"[0]", b'{"run": {}}'])
def test_a_damaged_snapshot_is_refused(picked, tmp_path, data):
    recording = Recording(rewrite(picked, tmp_path / "run.mcap", SNAPSHOTS, data))
    with pytest.raises(BtManipError, match="run.mcap is damaged"):
        Continuation(recording, 0.5)


def test_a_pose_that_is_no_number_is_shown(picked, tmp_path):
    message = FrameTransforms()
    with picked.open("rb") as file:
        _, _, first = next(iter(make_reader(file).iter_messages(["/tf"])))
    message.ParseFromString(first.data)
    for one in message.transforms:
        one.translation.x = float("nan")
    show(Recording(rewrite(picked, tmp_path / "run.mcap", "/tf", message.SerializeToString())))


def test_a_constant_of_json_is_no_error_of_the_reader(picked, tmp_path):
    state = {"force": [float("nan")] * 3, "torque": [0.0] * 3, "grip_forces": [0.0, 0.0]}
    state |= {"held": [], "saturated_steps": 0, "speed_scale": float("inf")}
    data = json.dumps(state).encode()
    show(Recording(rewrite(picked, tmp_path / "run.mcap", "/robots/panda/state", data)))


@pytest.mark.parametrize("missing", ["/cameras", "/tf", "/tf_static"])
def test_a_file_of_others_without_a_scene_is_refused(picked, tmp_path, missing):
    path = tmp_path / "run.mcap"
    with picked.open("rb") as file, path.open("wb") as out:
        writer = Writer(out)
        writer.start()
        for _, channel, message in make_reader(file).iter_messages(ending_before=100_000_000):
            if channel.topic != missing:
                number = writer.register_channel(channel.topic, channel.message_encoding, 0)
                writer.add_message(number, message.log_time, message.data, message.log_time)
        writer.finish()
    with pytest.raises(BtManipError, match="run.mcap has no complete chunk: it has no scene"):
        RecordedScene(Recording(path))
