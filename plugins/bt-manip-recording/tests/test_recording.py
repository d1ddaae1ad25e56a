"""Recordings with any content are read or refused with one line."""

import json
import resource
import subprocess
import sys

import lz4.frame
import pytest
import zstandard
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.writer import MCAP0_MAGIC, Writer

from bt_manip.exceptions import BtManipError
from bt_manip_recording import Continuation, RecordedRun, RecordedScene, Recording, Timeline
from bt_manip_recording.mcap_recorder import SNAPSHOTS
from bt_manip_recording.protobuf import control_step_class


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
    """Read whatever a report and a page read."""
    RecordedRun(recording)
    Timeline(recording)
    scene = RecordedScene(recording)
    scene.poses()
    for time in scene.times:
        scene.seek(time)
        for entity in scene.entities():
            scene.shapes(entity)


def triangle(*indices):
    update = SceneUpdate()
    body = update.entities.add(frame_id="table/table")
    body.triangles.add(indices=indices).points.add(x=1.0)
    return update.SerializeToString()


STEP = control_step_class()
JOINTS = "/robots/panda/joints"


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
    state |= {"held": [], "gripped": [], "saturated_steps": 0, "speed_scale": float("inf")}
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


def chunk_file(path, compression, data, size):
    """Write a file of one chunk, which claims a size."""
    record = RecordBuilder()
    Chunk(compression, data, 0, 0, 0, size).write(record)
    path.write_bytes(MCAP0_MAGIC + record.end())
    return path


def zeros(compression, size):
    """Compress zeros without having all of them at once."""
    if compression == "lz4":
        compressor = lz4.frame.LZ4FrameCompressor()
        head = compressor.begin()
    else:
        compressor, head = zstandard.ZstdCompressor().compressobj(), b""
    blocks = (compressor.compress(bytes(1 << 24)) for _ in range(size >> 24))
    return head + b"".join(blocks) + compressor.flush()


READ = """
import sys
from bt_manip.exceptions import BtManipError
from bt_manip_recording import Recording

for path in sys.argv[1:]:
    try:
        Recording(path)
    except BtManipError as error:
        print(error)
"""


def test_a_small_chunk_that_holds_more_than_the_memory_is_refused(tmp_path):
    files = [
        chunk_file(tmp_path / f"{kind}.mcap", kind, zeros(kind, (1 << 29) + (1 << 27)), 100)
        for kind in ("lz4", "zstd")
    ]
    limit = lambda: resource.setrlimit(resource.RLIMIT_DATA, (1 << 29, 1 << 29))  # noqa: E731
    command = [sys.executable, "-c", READ, *files]
    done = subprocess.run(command, preexec_fn=limit, timeout=60, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("claims 100 bytes and has more") == 2


@pytest.mark.parametrize("claim", [(1 << 29) + 1, 1 << 63])
def test_a_chunk_that_claims_gigabytes_is_refused(tmp_path, claim):
    path = chunk_file(tmp_path / "run.mcap", "zstd", zstandard.compress(b""), claim)
    with pytest.raises(BtManipError, match="run.mcap is damaged: .* at most 536870912 are read"):
        Recording(path)


@pytest.mark.parametrize("size", [0, 99, 101])
@pytest.mark.parametrize("compression", ["", "lz4", "zstd"])
def test_a_chunk_of_another_size_than_it_claims_is_refused(tmp_path, compression, size):
    compress = {"": bytes, "lz4": lz4.frame.compress, "zstd": zstandard.compress}[compression]
    path = chunk_file(tmp_path / "run.mcap", compression, compress(b"\x80" * size), 100)
    with pytest.raises(BtManipError, match="run.mcap is damaged: a chunk claims 100 bytes and has"):
        Recording(path)


@pytest.mark.parametrize("compression", ["lz4", "zstd", "lzma"])
def test_a_chunk_that_cannot_be_decompressed_is_refused(tmp_path, compression):
    path = chunk_file(tmp_path / "run.mcap", compression, b"nothing of this kind", 100)
    with pytest.raises(BtManipError, match="run.mcap is damaged"):
        Recording(path)


def test_zeros_in_a_chunk_are_no_records(tmp_path):
    size = 1 << 28
    path = chunk_file(tmp_path / "run.mcap", "zstd", zeros("zstd", size), size)
    with pytest.raises(BtManipError, match="run.mcap is damaged: a record in a chunk has the opco"):
        Recording(path)


def test_zeros_after_the_last_chunk_are_the_end(picked, tmp_path):
    path = rewrite(picked, tmp_path / "run.mcap", "", None)
    topics = Recording(path).topics
    size = path.stat().st_size
    with path.open("r+b") as file:
        file.truncate(size - 1000)  # without its index
        file.truncate(1 << 40)
    recording = Recording(path)
    assert recording.topics == topics and not recording.complete
