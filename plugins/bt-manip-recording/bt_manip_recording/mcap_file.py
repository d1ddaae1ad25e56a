"""An MCAP file that is being written."""

import io
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

from bt_manip.record import check_exists, open_output, writing
from bt_manip_recording.protobuf import file_descriptor_set

CHUNK_DURATION = 1.0
"""Simulated time in a chunk [s]: short enough to seek, long enough to compress well."""

FLUSH_INTERVAL = 0.4
"""Wall time after which a chunk is written although it is not full [s]."""

FLAT_OBJECT = b'{"type":"object"}'
"""JSON schema of the messages that are JSON."""


class CountingWriter(io.BufferedWriter):
    """Counts the written bytes, since a pipe has no position."""

    _size = 0

    def write(self, data: Any) -> int:
        """Write bytes; return their number."""
        self._size += len(data)
        return super().write(data)

    def tell(self) -> int:
        """Return the position [bytes]."""
        return self._size


PACK_HEAD = struct.Struct("<BQHIQQ").pack
"""Header of a message record: opcode, length, channel, sequence number, two times."""

HEAD_LENGTH = 31
"""Length of the result of `PACK_HEAD` [bytes]; the length of a record leaves out the first 9."""


class BlockWriter(Writer):
    """The library's writer, which adds many messages at once to its chunk.

    Its own `add_message` takes 5 us, which at 1 kHz is 5 % of a recorded run. The chunk
    is private to the library: a test compares the files of both.
    """

    def add_messages(
        self, channel: int, times: Sequence[int], data: Sequence[bytes], sequences: Sequence[int]
    ) -> None:
        """Add messages of a channel.

        Args:
            channel: The number of the channel.
            times: Times of the messages [ns].
            data: Their contents.
            sequences: Their sequence numbers.
        """
        chunk: Any = getattr(self, "_Writer__chunk_builder")  # noqa: B009
        total: Any = getattr(self, "_Writer__statistics")  # noqa: B009
        entries = chunk.message_indices.setdefault(channel, MessageIndex(channel, [])).records
        offset: int = chunk.count
        records: list[bytes] = []
        for time_ns, content, sequence in zip(times, data, sequences, strict=True):
            length = HEAD_LENGTH + len(content)
            head = PACK_HEAD(Opcode.MESSAGE, length - 9, channel, sequence, time_ns, time_ns)
            records += head, content
            entries.append((time_ns, offset))
            offset += length
        chunk.record_writer.write(b"".join(records))
        first, last = min(times), max(times)
        for count, known in ((chunk.num_messages, chunk), (total.message_count, total)):
            known.message_start_time = min(first, known.message_start_time) if count else first
            known.message_end_time = max(last, known.message_end_time)
        chunk.num_messages += len(times)
        total.message_count += len(times)
        total.channel_message_counts[channel] += len(times)


class McapFile:
    """Writes messages in chunks of equal simulated time, with an index at the end.

    In slow runs a thread writes unfinished chunks, so that a killed process loses at most
    one and a half `FLUSH_INTERVAL` of wall time. The same fast run gives the same chunks.
    When the disk is full, the run continues, and `close` raises.

    Args:
        path: The file.
        encode: Called before a chunk is written, under the `lock`: adds copied states.

    Raises:
        RecordingError: If it cannot be written.

    Attributes:
        lock: Held while something is added or written.
        sequence: Sequence number of the messages that `add` adds: the number of ticks begun before.
    """

    def __init__(self, path: Path, encode: Callable[[], None]) -> None:
        self._path = path
        with writing(path, "recording"):
            self._file = CountingWriter(open_output(path))
        # Chunks end by time; joints compress hardly better with zstd, and much slower.
        self._writer = BlockWriter(self._file, 1 << 62, CompressionType.LZ4, enable_data_crcs=True)
        self._writer.start("", "bt-manip")
        self._to_json = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._topics: dict[str, str] = {}
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
    def topics(self) -> dict[str, str]:
        """The topics so far, with the names of their schemas."""
        return dict(self._topics)

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
            self._topics[topic] = name
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
        self._add(topic, [nanoseconds], [data], [self.sequence])

    def add_all(
        self,
        topic: str,
        times: np.ndarray,
        data: Sequence[bytes] | np.ndarray,
        sequences: Sequence[int] | None = None,
    ) -> None:
        """Add serialized messages of a topic.

        Args:
            topic: A registered topic.
            times: Simulated times [s].  # (n,)
            data: Their contents; those of equal length may be the rows of an array.
            sequences: Their sequence numbers; None: 0.
        """
        contents = [row.tobytes() for row in data] if isinstance(data, np.ndarray) else data
        ticks = np.rint(times * 1e9).astype(np.int64).tolist()
        self._add(topic, ticks, contents, sequences or [0] * len(ticks))

    def _add(
        self, topic: str, times: Sequence[int], data: Sequence[bytes], sequences: Sequence[int]
    ) -> None:
        if times and self._error is None:
            with self.lock:
                self._writer.add_messages(self._channels[topic], times, data, sequences)

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
