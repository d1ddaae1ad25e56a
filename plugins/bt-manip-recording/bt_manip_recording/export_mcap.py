"""Rewriting of a recording that was cut."""

from pathlib import Path

from mcap.records import Channel, Chunk, Message, Metadata, Schema
from mcap.stream_reader import breakup_chunk
from mcap.writer import CompressionType, Writer

from bt_manip.record import whole_file, writing
from bt_manip_recording.recording import Recording

CHUNK_SIZE = 1 << 20
"""Size of a chunk before compression [bytes], as the library's default."""


def write_mcap(recording: Recording, path: Path) -> None:
    """Write the readable part of a recording as a complete MCAP file, with an index.

    Each message keeps its time, its sequence number and its bytes.
    """
    with writing(path, "recording"), recording.decoding(), whole_file(path) as file:
        writer = Writer(file, CHUNK_SIZE, CompressionType.ZSTD, enable_data_crcs=True)
        writer.start("", "bt-manip")
        schemas, channels = {0: 0}, {}
        for record in recording.records():
            if isinstance(record, Schema) and record.id not in schemas:
                content = record.name, record.encoding, record.data
                schemas[record.id] = writer.register_schema(*content)
            elif isinstance(record, Channel) and record.id not in channels:
                about = record.topic, record.message_encoding, schemas[record.schema_id]
                channels[record.id] = writer.register_channel(*about, record.metadata)
            elif isinstance(record, Metadata):
                writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Chunk):
                for message in breakup_chunk(record):
                    if isinstance(message, Message):
                        rest = message.log_time, message.data, message.publish_time
                        channel = channels[message.channel_id]
                        writer.add_message(channel, *rest, message.sequence)
        writer.finish()
