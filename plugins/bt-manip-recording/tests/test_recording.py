"""Recordings with any content are read or refused with one line."""

import csv
import json
import resource
import subprocess
import sys
from types import MappingProxyType

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
from bt_manip_recording import (
    Continuation,
    RecordedRun,
    RecordedScene,
    Recording,
    Timeline,
    write_csv,
)
from bt_manip_recording.mcap_recorder import SNAPSHOTS
from bt_manip_recording.protobuf import control_step_class


def rewrite(source, target, topic="", data=None, metadata=MappingProxyType({})):
    """Copy the first second of a recording, with other messages of a topic, or without them."""
    with source.open("rb") as file, target.open("wb") as out:
        reader, writer, channels = make_reader(file), Writer(out), {}
        writer.start()
        for one in reader.iter_metadata():
            writer.add_metadata(one.name, metadata.get(one.name, one.metadata))
        for _, channel, message in reader.iter_messages(ending_before=1_000_000_000):
            name, time = channel.topic, message.log_time
            if (new := data if name == topic else message.data) is None:
                continue
            if name not in channels:
                texts = metadata.get(name, channel.metadata)
                channels[name] = writer.register_channel(name, channel.message_encoding, 0, texts)
            writer.add_message(channels[name], time, new, time, message.sequence)
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
    path = rewrite(picked, tmp_path / "run.mcap", metadata=metadata)
    with pytest.raises(BtManipError, match="run.mcap is damaged"):
        Recording(path)


@pytest.mark.parametrize("data", [b"1", b"[0]", b'{"run": {}}'])
def test_a_damaged_snapshot_is_refused(picked, tmp_path, data):
    recording = Recording(rewrite(picked, tmp_path / "run.mcap", SNAPSHOTS, data))
    with pytest.raises(BtManipError, match="run.mcap is damaged"):
        Continuation(recording, 0.5)


def test_numbers_that_are_not_finite_are_shown(picked, tmp_path):
    poses = FrameTransforms.FromString(next(Recording(picked).messages("/tf"))[2])
    for one in poses.transforms:
        one.translation.x = float("nan")
    state = {"force": [float("nan")] * 3, "torque": [0.0] * 3, "grip_forces": [0.0, 0.0]}
    state |= {"held": [], "gripped": [], "saturated_steps": 0, "speed_scale": float("inf")}
    contents = {
        "/tf": poses.SerializeToString(), "/robots/panda/state": json.dumps(state).encode()
    }  # fmt: skip
    for topic, data in contents.items():
        show(Recording(rewrite(picked, tmp_path / "run.mcap", topic, data)))


@pytest.mark.parametrize("missing", ["/cameras", "/tf", "/tf_static"])
def test_a_file_of_others_without_a_scene_is_refused(picked, tmp_path, missing):
    path = rewrite(picked, tmp_path / "run.mcap", missing)
    with pytest.raises(BtManipError, match="run.mcap has no complete chunk: it has no scene"):
        RecordedScene(Recording(path))


def test_the_states_of_a_page_without_forces_are_exported(picked, tmp_path):
    path = rewrite(picked, tmp_path / "run.mcap", "/robots/panda/state")
    write_csv(Recording(path), tmp_path / "run.csv")
    header, first, *_ = csv.reader((tmp_path / "run.csv").read_text().splitlines())
    assert dict(zip(header, first, strict=True))["panda/force_x"] == ""


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


COMPRESS = {"": bytes, "lz4": lz4.frame.compress, "zstd": zstandard.compress}
OTHER_SIZES = [
    (kind, compress(b"\x80" * size), 100, "a chunk claims 100 bytes and has")
    for kind, compress in COMPRESS.items()
    for size in (0, 99, 101)
]


@pytest.mark.parametrize(
    ("compression", "data", "claim", "message"),
    [
        *OTHER_SIZES,
        ("zstd", zstandard.compress(b""), (1 << 29) + 1, ".* at most 536870912 are read"),
        ("zstd", zstandard.compress(b""), 1 << 63, ".* at most 536870912 are read"),
        ("lz4", b"nothing of this kind", 100, ""),
        ("zstd", b"nothing of this kind", 100, ""),
        ("lzma", b"", 0, "unknown compression 'lzma'"),
        ("", bytes(1 << 24), 1 << 24, "a record in a chunk has the opcode 0"),
    ],
)
def test_a_chunk_that_does_not_hold_what_it_claims_is_refused(
    tmp_path, compression, data, claim, message
):
    path = chunk_file(tmp_path / "run.mcap", compression, data, claim)
    with pytest.raises(BtManipError, match=f"run.mcap is damaged: {message}"):
        Recording(path)


def test_zeros_after_the_last_chunk_are_the_end(picked, tmp_path):
    path = rewrite(picked, tmp_path / "run.mcap")
    topics = Recording(path).topics
    size = path.stat().st_size
    with path.open("r+b") as file:
        file.truncate(size - 1000)  # without its index
        file.truncate(1 << 40)
    recording = Recording(path)
    assert recording.topics == topics and not recording.complete
