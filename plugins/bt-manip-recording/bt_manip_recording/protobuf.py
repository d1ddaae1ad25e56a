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
    field = descriptor_pb2.FieldDescriptorProto
    for number, name in enumerate((*STEP_FIELDS, "free", "tool"), 1):
        kind = field.TYPE_BOOL if name == "free" else field.TYPE_DOUBLE
        label = field.LABEL_OPTIONAL if name == "free" else field.LABEL_REPEATED
        message.field.add(name=name, number=number, type=kind, label=label)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("bt_manip.ControlStep"))


FREE = -27
"""Position of the value of ``free`` in a message: before ``tool``, tag, length and 24 bytes."""


def control_step_template(joints: int) -> "NumberTemplate":
    """Return the template of the `control_step_class` of a robot with some joints.

    Its numbers are the arrays of `STEP_FIELDS`, one after the other, and the tool's position.
    """
    make, count = control_step_class(), len(STEP_FIELDS) * joints

    def build(numbers: Sequence[float]) -> Any:
        arrays = [numbers[i : i + joints] for i in range(0, count, joints)]
        steps = dict(zip(STEP_FIELDS, arrays, strict=True))
        return make(**steps, free=True, tool=numbers[count:])

    return NumberTemplate(build, count + 3)


class NumberTemplate:
    """A serialized message whose doubles are replaced without serializing it again.

    Doubles have a fixed width of eight bytes on the wire, so all messages of one structure have
    their numbers at the same positions. Setting the fields of a message one by one would take
    longer than a control step of the physics.

    Args:
        build: Makes the message of some numbers.
        count: Number of doubles in the message.

    Attributes:
        data: A message with other numbers.
    """

    def __init__(self, build: Callable[[Sequence[float]], Any], count: int) -> None:
        marks = np.random.default_rng(0).random(count)  # distinct and never zero
        self.data = build(marks.tolist()).SerializeToString()
        self._starts = [self.data.find(struct.pack("<d", mark)) for mark in marks]
        assert -1 not in self._starts

    def serialize(self, numbers: np.ndarray) -> np.ndarray:
        """Return serialized messages of doubles, in the order of ``build``; each has a row."""
        data = np.tile(np.frombuffer(self.data, dtype=np.uint8), (len(numbers), 1))
        wire = np.ascontiguousarray(numbers, dtype="<f8").view(np.uint8)
        for i, start in enumerate(self._starts):
            data[:, start : start + 8] = wire[:, 8 * i : 8 * i + 8]
        return data
