"""An MCAP file that is being written."""

import io
import json
import struct
import threading
import time
import zlib
from array import array
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import lz4.frame
import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)  # fmt: skip
from mcap.writer import MCAP0_MAGIC

from bt_manip.record.files import check_exists, open_output, writing
from bt_manip.record.mcap.protobuf import file_descriptor_set

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

PACK_INDEX = struct.Struct("<BQHI").pack
"""Serializes the head of a message index: opcode, length, channel, length of the entries."""

FRAMING = 9
"""Bytes of a record that its length leaves out: opcode and length."""


class _Chunk:
    """The chunk that is being filled: its records, and where the messages of each channel are."""

    def __init__(self) -> None:
        self.records = RecordBuilder()
        self.messages = 0
        self.first = self.last = 0  # [ns]
        self.entries: dict[int, array[int]] = {}  # by channel: time [ns] and offset in turn


class BlockWriter:
    """Writes the records of an MCAP file in chunks, many messages at once.

    The library's writer makes each message and each entry of an index by a dozen calls, which at
    1 kHz would take a tenth of the time of the simulation. Its records are used for all else.
    """

    def __init__(self, file: BinaryIO) -> None:
        """Write the header.

        Args:
            file: The file; it only needs to be written, so it may be a pipe.
        """
        self._file, self._size = file, 0
        self._chunk = _Chunk()
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._statistics = Statistics(0, 0, defaultdict(int), 0, 0, 0, 0, 0, 0)
        self._write(MCAP0_MAGIC + _bytes_of(Header(profile="", library="bt-manip")))

    def register_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema; return its number."""
        self._schemas.append(Schema(len(self._schemas) + 1, data, encoding, name))
        self._schemas[-1].write(self._chunk.records)
        return self._schemas[-1].id

    def register_channel(
        self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]
    ) -> int:
        """Add a channel; return its number."""
        number = len(self._channels) + 1
        self._channels.append(Channel(number, topic, encoding, dict(metadata), schema))
        self._channels[-1].write(self._chunk.records)
        return number

    def add_metadata(self, name: str, texts: Mapping[str, str]) -> None:
        """Write texts about the whole file."""
        data = _bytes_of(Metadata(name=name, metadata=dict(texts)))
        self._metadata.append(MetadataIndex(length=len(data), name=name, offset=self._size))
        self._write(data)

    def add_messages(
        self, channel: int, times: Sequence[int], data: Sequence[bytes], sequence: int = 0
    ) -> None:
        """Add messages of any lengths.

        Args:
            channel: The number of their channel.
            times: Their times [ns].
            data: Their contents.
            sequence: Their sequence number.
        """
        length = MESSAGE_HEAD.itemsize - FRAMING
        chunk = self._count(channel, len(times), min(times), max(times))
        offset, entries = chunk.records.count, chunk.entries[channel]
        records: list[bytes] = []
        for at, content in zip(times, data, strict=True):
            head = PACK_HEAD(Opcode.MESSAGE, length + len(content), channel, sequence, at, at)
            records += head, content
            entries.extend((at, offset))
            offset += MESSAGE_HEAD.itemsize + len(content)
        chunk.records.write(b"".join(records))

    def add_block(
        self, channel: int, times: np.ndarray, data: np.ndarray, sequences: np.ndarray | int = 0
    ) -> None:
        """Add messages of equal length, as `add_messages` would.

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
        offsets = chunk.records.count + block.shape[1] * np.arange(n)
        chunk.entries[channel].frombytes(np.column_stack((times, offsets)).astype("u8").tobytes())
        chunk.records.write(block.data)

    def flush(self) -> None:
        """Write the chunk, if it has messages."""
        chunk = self._chunk
        if chunk.messages:
            self._chunk = _Chunk()
            data = chunk.records.end()
            packed = lz4.frame.compress(data)
            times = chunk.last, chunk.first
            record = _bytes_of(Chunk("lz4", packed, *times, zlib.crc32(data), len(data)))
            offsets, indexes, start = {}, b"", self._size
            for channel, entries in chunk.entries.items():
                offsets[channel] = start + len(record) + len(indexes)
                size = len(entries) * entries.itemsize
                indexes += PACK_INDEX(Opcode.MESSAGE_INDEX, 6 + size, channel, size)
                indexes += entries.tobytes()
            self._write(record + indexes)
            sizes = len(packed), chunk.last, len(indexes), offsets, chunk.first, len(data)
            self._chunks.append(ChunkIndex(len(record), start, "lz4", *sizes))
        self._file.flush()

    def finish(self) -> None:
        """Write the last chunk and the summary."""
        self.flush()
        self._write(_bytes_of(DataEnd(data_section_crc=0)))
        statistics, start = self._statistics, self._size
        statistics.schema_count, statistics.channel_count = len(self._schemas), len(self._channels)
        statistics.chunk_count, statistics.metadata_count = len(self._chunks), len(self._metadata)
        groups: dict[Opcode, Sequence[McapRecord]] = {
            Opcode.SCHEMA: self._schemas, Opcode.CHANNEL: self._channels,
            Opcode.STATISTICS: [statistics], Opcode.CHUNK_INDEX: self._chunks,
            Opcode.ATTACHMENT_INDEX: [], Opcode.METADATA_INDEX: self._metadata,
        }  # fmt: skip
        summary, offsets = b"", []
        for opcode, records in groups.items():
            data = _bytes_of(*records)
            offsets.append(SummaryOffset(opcode, start + len(summary), len(data)))
            summary += data
        footer = Footer(start, start + len(summary), 0)
        summary += _bytes_of(*offsets)
        # The checksum is of the summary, and of the footer before the checksum itself.
        footer.summary_crc = zlib.crc32(summary + _bytes_of(footer)[:-4])
        self._write(summary + _bytes_of(footer) + MCAP0_MAGIC)

    def _write(self, data: bytes) -> None:
        self._file.write(data)
        self._size += len(data)

    def _count(self, channel: int, n: int, first: int, last: int) -> _Chunk:
        """Count messages of a channel from a first to a last time [ns]; return their chunk."""
        chunk, total = self._chunk, self._statistics
        chunk.first = min(first, chunk.first) if chunk.messages else first
        start = min(first, total.message_start_time) if total.message_count else first
        total.message_start_time = start
        chunk.last, total.message_end_time = (
            max(last, chunk.last),
            max(last, total.message_end_time),
        )
        chunk.messages += n
        total.message_count += n
        total.channel_message_counts[channel] += n
        if channel not in chunk.entries:
            chunk.entries[channel] = array("Q")
        return chunk


def _bytes_of(*records: McapRecord) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()


class McapFile:
    """Writes messages in chunks of equal simulated time, with an index at the end.

    In slow runs a thread writes unfinished chunks, so that a killed process loses at most
    one and a half `FLUSH_INTERVAL` of wall time. The same fast run gives the same chunks.
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
            self._file = io.BufferedWriter(open_output(path))
        # Chunks end by time; joints compress hardly better with zstd, and much slower.
        self._writer = BlockWriter(self._file)
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
                topic, encodings[1], self._schemas[name], metadata or {}
            )

    def add_metadata(self, name: str, texts: Mapping[str, str]) -> None:
        """Add texts about the whole file."""
        with self.lock:
            try:
                self._writer.add_metadata(name, texts)
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
            self._writer.add_messages(self._channels[topic], [nanoseconds], [data], self.sequence)

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
            self._writer.add_messages(channel, ticks.tolist(), data)

    def end_tick(self, nanoseconds: int) -> None:
        """Write the chunk if it is full at a simulated time [ns]."""
        if nanoseconds - self._chunk_start >= CHUNK_DURATION * 1e9:
            self._chunk_start = nanoseconds
            self._flush()

    def close(self) -> None:
        """Write the last chunk and the index.

        Raises:
            RecordingError: If the file could not be written, now or before, or was deleted.
        """
        self._closed.set()
        self._thread.join()
        self._flush()
        try:
            if self._error is None:
                self._writer.finish()
                self._file.flush()
                check_exists(self._file)
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
