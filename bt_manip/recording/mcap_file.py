"""An MCAP file that is being written."""

import json
import struct
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from mcap.records import MessageIndex
from mcap.writer import CompressionType, Writer

from bt_manip.recording.files import writing
from bt_manip.recording.protobuf import file_descriptor_set

CHUNK_DURATION = 1.0
"""Simulated time in a chunk [s]: short enough to seek, long enough to compress well."""

FLUSH_INTERVAL = 0.4
"""Wall time after which a chunk is written although it is not full [s]."""

FLAT_OBJECT = b'{"type":"object"}'
"""JSON schema of the messages that are JSON."""

MESSAGE_HEAD = np.dtype([
    ("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"),
    ("log_time", "<u8"), ("publish_time", "<u8"),
])  # fmt: skip
"""Fields of a message on the wire before its data."""

PACK_HEAD = struct.Struct("<BQHIQQ").pack
"""Serializes a `MESSAGE_HEAD`."""

FRAMING = 9
"""Bytes of a record that its length leaves out: opcode and length."""


class BlockIndex(MessageIndex):
    """An index of the messages of a chunk, with the entries of a block in one array.

    A tuple for each message would make Python's garbage collector run more often, which takes
    longer than the recording.
    """

    def __init__(self, channel_id: int, records: list[tuple[int, int]]) -> None:
        """Begin with the entries of single messages."""
        super().__init__(channel_id, records)
        self.blocks: list[np.ndarray] = []  # (n, 2) each: time [ns] and offset

    def write(self, stream: Any) -> None:
        """Write the index."""
        blocks = [np.array(self.records, dtype="<i8").reshape(-1, 2), *self.blocks]
        data = np.concatenate(blocks).astype("<u8").tobytes()
        stream.start_record(Opcode.MESSAGE_INDEX)
        stream.write2(self.channel_id)
        stream.write4(len(data))
        stream.write(data)
        stream.finish_record()


class BlockWriter(Writer):
    """The library's writer, with fast ways to add messages.

    The library makes each message and each entry of an index by a dozen calls, which at 1 kHz
    would take a tenth of the time of the simulation.
    """

    def add_message(
        self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int = 0
    ) -> None:
        """Add a message, as the library does."""
        chunk = self._count(channel_id, 1, log_time, log_time)
        chunk.message_indices[channel_id].records.append((log_time, chunk.count))
        length = MESSAGE_HEAD.itemsize - FRAMING + len(data)
        about = channel_id, sequence, log_time, publish_time
        chunk.record_writer.write(PACK_HEAD(Opcode.MESSAGE, length, *about) + data)

    def add_messages(self, channel: int, times: np.ndarray, data: Sequence[bytes]) -> None:
        """Add messages of any lengths, as `add_message` would one by one.

        Args:
            channel: The number of their channel.
            times: Times of the messages, whole numbers [ns].  # (n,)
            data: Their contents.
        """
        n, length = len(times), MESSAGE_HEAD.itemsize - FRAMING
        records = [
            PACK_HEAD(Opcode.MESSAGE, length + len(content), channel, 0, time, time) + content
            for time, content in zip(times.tolist(), data, strict=True)
        ]
        chunk = self._count(channel, n, int(times.min()), int(times.max()))
        offsets = np.cumsum([chunk.count, *map(len, records[:-1])])
        chunk.message_indices[channel].blocks.append(np.column_stack((times, offsets)))
        chunk.record_writer.write(b"".join(records))

    def add_block(
        self,
        channel: int,
        times: np.ndarray,
        data: np.ndarray,
        sequences: np.ndarray | int = 0,
    ) -> None:
        """Add messages of equal length, as `add_message` would one by one.

        Args:
            channel: The number of their channel.
            times: Times of the messages, whole numbers [ns].  # (n,)
            data: Their contents.  # (n, bytes)
            sequences: Their sequence numbers.
        """
        n, start = len(times), MESSAGE_HEAD.itemsize
        heads = np.empty(n, MESSAGE_HEAD)
        heads["opcode"], heads["channel"], heads["sequence"] = Opcode.MESSAGE, channel, sequences
        heads["length"] = start - FRAMING + data.shape[1]
        heads["log_time"] = heads["publish_time"] = times
        block = np.empty((n, start + data.shape[1]), np.uint8)
        block[:, :start] = heads.view(np.uint8).reshape(n, start)
        block[:, start:] = data
        chunk = self._count(channel, n, int(times.min()), int(times.max()))
        offsets = chunk.count + block.shape[1] * np.arange(n)
        chunk.message_indices[channel].blocks.append(np.column_stack((times, offsets)))
        chunk.record_writer.write(block)

    def _count(self, channel: int, n: int, first: int, last: int) -> Any:
        """Count messages of a channel from a first to a last time [ns]; return their chunk."""
        chunk, statistics = self._Writer__chunk_builder, self._Writer__statistics  # type: ignore
        if channel not in chunk.message_indices:
            chunk.message_indices[channel] = BlockIndex(channel, [])
        if chunk.num_messages == 0 or first < chunk.message_start_time:
            chunk.message_start_time = first
        chunk.message_end_time = max(chunk.message_end_time, last)
        if statistics.message_count == 0 or first < statistics.message_start_time:
            statistics.message_start_time = first
        statistics.message_end_time = max(statistics.message_end_time, last)
        chunk.num_messages += n
        statistics.message_count += n
        statistics.channel_message_counts[channel] += n
        return chunk


class McapFile:
    """Writes messages in chunks of equal simulated time, with an index at the end.

    In slow runs a thread writes unfinished chunks, so that a killed process loses at most
    one and a half `FLUSH_INTERVAL` of wall time. The same fast run gives the same bytes.
    When the disk is full, the run continues, and `close` raises.

    Attributes:
        lock: Held while something is added or written.
        sequence: Sequence number of the messages that `add` adds: the number of ticks begun before.
    """

    def __init__(self, path: Path, encode: Callable[[], None]) -> None:
        """Open the file.

        Args:
            path: The file.
            encode: Called before a chunk is written, under the `lock`: adds copied states.

        Raises:
            RecordingError: If it cannot be written.
        """
        self._path = path
        with writing(path, "recording"):
            self._file = path.open("wb")
        # Chunks end by time; joints compress hardly better with zstd, and much slower.
        self._writer = BlockWriter(self._file, 1 << 30, CompressionType.LZ4)
        self._writer.start("", "bt-manip")
        self._to_json = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._chunk_start = 0  # [ns]
        self._flushed = time.monotonic()
        self._error: OSError | None = None
        self._encode = encode
        self.sequence = 0
        self.lock = threading.RLock()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._flush_when_due, daemon=True)
        self._thread.start()

    @property
    def topics(self) -> list[str]:
        """The topics so far."""
        return list(self._channels)

    def add_topic(
        self, topic: str, message: Any = None, metadata: Mapping[str, str] | None = None
    ) -> None:
        """Register a topic before its first message.

        Args:
            topic: Its name; a known topic is kept.
            message: The class of its protobuf messages; None for JSON.
            metadata: Further texts.
        """
        if topic in self._channels:
            return
        with self.lock:
            name, encodings = "bt_manip.Event", ("jsonschema", "json")
            if message is not None:
                name, encodings = message.DESCRIPTOR.full_name, ("protobuf", "protobuf")
            if name not in self._schemas:
                schema = FLAT_OBJECT if message is None else file_descriptor_set(message)
                self._schemas[name] = self._writer.register_schema(name, encodings[0], schema)
            self._channels[topic] = self._writer.register_channel(
                topic, encodings[1], self._schemas[name], dict(metadata or {})
            )

    def add_metadata(self, name: str, texts: Mapping[str, str]) -> None:
        """Add texts about the whole file."""
        with self.lock:
            try:
                self._writer.add_metadata(name, dict(texts))
            except OSError as error:
                self._error = error

    def add_json(self, topic: str, nanoseconds: int, data: Mapping[str, Any]) -> None:
        """Add a JSON message; an unknown topic is registered."""
        if topic not in self._channels:
            self.add_topic(topic)
        self.add(topic, nanoseconds, self._to_json(data).encode())

    def add(self, topic: str, nanoseconds: int, data: bytes) -> None:
        """Add a serialized message of a registered topic at a simulated time [ns]."""
        if self._error is not None:
            return
        with self.lock:
            self._writer.add_message(
                self._channels[topic], nanoseconds, data, nanoseconds, self.sequence
            )

    def add_all(
        self,
        topic: str,
        times: np.ndarray,
        data: Sequence[bytes] | np.ndarray,
        sequences: np.ndarray | int = 0,
    ) -> None:
        """Add serialized messages of a topic.

        Args:
            topic: A registered topic.
            times: Simulated times [s].  # (n,)
            data: Their contents; those of equal length may be the rows of an array.
            sequences: Their sequence numbers, of an array only.
        """
        if not len(data) or self._error is not None:
            return
        ticks = np.rint(times * 1e9).astype(np.int64)
        channel = self._channels[topic]
        with self.lock:
            if isinstance(data, np.ndarray):
                self._writer.add_block(channel, ticks, data, sequences)
                return
            self._writer.add_messages(channel, ticks, data)

    def end_tick(self, nanoseconds: int) -> None:
        """Write the chunk if it is full at a simulated time [ns]."""
        if nanoseconds - self._chunk_start >= CHUNK_DURATION * 1e9:
            self._chunk_start = nanoseconds
            self._flush()

    def close(self) -> None:
        """Write the last chunk and the index.

        Raises:
            RecordingError: If the file could not be written, now or before.
        """
        self._closed.set()
        self._thread.join()
        self._flush()
        try:
            if self._error is None:
                self._writer.finish()
                self._file.flush()
        except OSError as error:
            self._error = error
        with suppress(OSError):  # raised again for data that an error above has left
            self._file.close()
        if self._error is not None:
            with writing(self._path, "recording"):
                raise self._error

    def _flush(self) -> None:
        """Write the messages so far; after an error nothing more is written."""
        with self.lock:
            self._encode()
            self._flushed = time.monotonic()
            if self._error is None:
                try:
                    self._writer.flush()
                except OSError as error:
                    self._error = error

    def _flush_when_due(self) -> None:
        while not self._closed.wait(0.5 * FLUSH_INTERVAL):
            if time.monotonic() - self._flushed > FLUSH_INTERVAL:
                self._flush()
