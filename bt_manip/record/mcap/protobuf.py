"""Protobuf messages of recordings: their schemas, and fast serialization of their numbers."""

import struct
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

from bt_manip.runner import STEP_FIELDS


def file_descriptor_set(message: Any) -> bytes:
    """Return the schema of a message class as MCAP stores it: a FileDescriptorSet."""
    files: dict[str, Any] = {}

    def add(file: Any) -> None:
        if file.name not in files:
            for dependency in file.dependencies:
                add(dependency)
            files[file.name] = file

    add(message.DESCRIPTOR.file)
    found = descriptor_pb2.FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(found.file.add())
    return found.SerializeToString()


def control_step_class() -> Any:
    """Return the class of messages that hold one control step of a robot."""
    file = descriptor_pb2.FileDescriptorProto(
        name="bt_manip/ControlStep.proto", package="bt_manip", syntax="proto3"
    )
    message = file.message_type.add(name="ControlStep")
    for number, name in enumerate(STEP_FIELDS, 1):
        message.field.add(
            name=name,
            number=number,
            type=descriptor_pb2.FieldDescriptorProto.TYPE_DOUBLE,
            label=descriptor_pb2.FieldDescriptorProto.LABEL_REPEATED,
        )
    kind = descriptor_pb2.FieldDescriptorProto.TYPE_BOOL
    message.field.add(name="free", number=len(STEP_FIELDS) + 1, type=kind)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("bt_manip.ControlStep"))


class ControlStepTemplate:
    """Serializes many control steps at once: their arrays stand on the wire as in memory."""

    def __init__(self, joints: int) -> None:
        """Serialize one step.

        Args:
            joints: Length of each array.
        """
        step = control_step_class()(**dict.fromkeys(STEP_FIELDS, [0.0] * joints), free=True)
        self._data = np.frombuffer(step.SerializeToString(), dtype=np.uint8)
        self._width = 8 * joints

    def serialize(self, steps: np.ndarray, free: Sequence[bool]) -> np.ndarray:
        """Return the messages, one per row.

        Args:
            steps: The arrays of `STEP_FIELDS` one after the other.  # (n, fields * joints)
            free: The field ``free``, which is the last one.  # (n,)
        """  # (n, bytes)
        data = np.tile(self._data, (len(steps), 1))
        numbers = np.ascontiguousarray(steps, dtype="<f8").view(np.uint8)
        shape = len(steps), len(STEP_FIELDS), -1
        # Each array follows its tag and its length; the last field, a bool, takes two bytes.
        data[:, :-2].reshape(shape)[:, :, -self._width :] = numbers.reshape(shape)
        data[:, -1] = free
        return data


class NumberTemplate:
    """A serialized message whose doubles are replaced without serializing it again.

    Doubles have a fixed width of eight bytes on the wire, so all messages of one structure have
    their numbers at the same positions. Setting the fields of a message one by one would take
    longer than a control step of the physics.

    Attributes:
        data: A message with other numbers.
    """

    def __init__(self, build: Callable[[Sequence[float]], Any], count: int) -> None:
        """Find the positions of the numbers.

        Args:
            build: Makes the message of some numbers.
            count: Number of doubles in the message.
        """
        marks = 1e300 * (1.0 + np.arange(count) / (2.0 * count))  # distinct and never zero
        data = build(marks.tolist()).SerializeToString()
        starts = [data.find(struct.pack("<d", mark)) for mark in marks]
        assert -1 not in starts
        self.data = data
        self._where = (np.array(starts)[:, None] + np.arange(8)).ravel()

    def serialize(self, numbers: np.ndarray) -> np.ndarray:
        """Return the serialized messages of some doubles, in the order of ``build``.

        Args:
            numbers: The doubles of each message.  # (n, count)
        """  # (n, bytes)
        data = np.tile(np.frombuffer(self.data, dtype=np.uint8), (len(numbers), 1))
        data[:, self._where] = np.ascontiguousarray(numbers, dtype="<f8").view(np.uint8)
        return data
