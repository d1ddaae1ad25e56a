"""Leaves that work on lists."""

from bt_manip.bt import InOut, Input, Output
from bt_manip.exceptions import PortError
from bt_manip_moveit_pro.leaf import Leaf


def items_of(value: object) -> list[object]:
    """Return the items of a list; none for an empty text.

    Raises:
        ValueError: If it is no list.
    """
    if value == "":
        return []
    if not isinstance(value, list | tuple):
        raise ValueError(f"a list is expected, not {type(value).__name__}")
    return list(value)


def checked_index(index: int, length: int) -> int:
    """Return an index of a list.

    Raises:
        ValueError: If there is no item at it.
    """
    if not 0 <= index < length:
        raise ValueError(f"there is no item {index} among {length}")
    return index


class ResetVector(Leaf):
    """Write an empty list."""

    vector = Output(doc="the list")

    def _run(self) -> None:
        self.vector = []


class ResetPoseStampedVector(ResetVector):
    """Write an empty list for poses."""


class VectorLeaf(Leaf):
    """A leaf that writes a changed copy of a list."""

    input_vector = Input(default="", doc="the list")
    output_vector = Output(doc="the changed list")

    def _run(self) -> None:
        items = items_of(self.input_vector)
        self._change(items)
        self.output_vector = items

    def _change(self, items: list[object]) -> None:
        raise NotImplementedError


class PushBackVector(VectorLeaf):
    """Append an item to a list."""

    element = Input(doc="the item")

    def _change(self, items: list[object]) -> None:
        items.append(self.element)


class AddPoseStampedToVector(Leaf):
    """Append a pose to a list, which is made if there is none."""

    pose = Input(name="input", doc="the pose")
    vector = InOut(doc="the list")

    def _run(self) -> None:
        try:
            items = items_of(self.vector)
        except PortError:
            items = []
        self.vector = [*items, self.pose]


class InsertInVector(PushBackVector):
    """Insert an item into a list."""

    index = Input(int, doc="index of the item, from 0")

    def _change(self, items: list[object]) -> None:
        items.insert(checked_index(self.index, len(items) + 1), self.element)


class ReplaceInVector(PushBackVector):
    """Replace an item of a list."""

    index = Input(int, doc="index of the item, from 0")

    def _change(self, items: list[object]) -> None:
        items[checked_index(self.index, len(items))] = self.element


class RemoveFromVector(VectorLeaf):
    """Remove an item of a list."""

    index = Input(int, doc="index of the item, from 0")

    def _change(self, items: list[object]) -> None:
        del items[checked_index(self.index, len(items))]


class ReversePoseStampedVector(VectorLeaf):
    """Reverse a list."""

    def _change(self, items: list[object]) -> None:
        items.reverse()


class GetElementOfVector(Leaf):
    """Get an item of a list."""

    vector_in = Input(doc="the list")
    index = Input(int, default=0, doc="index of the item, from 0")
    element = Output(doc="the item")

    def _run(self) -> None:
        items = items_of(self.vector_in)
        self.element = items[checked_index(self.index, len(items))]


class GetSizeOfVector(Leaf):
    """Count the items of a list."""

    vector_in = Input(doc="the list")
    vector_size = Output(int, doc="the number of its items")

    def _run(self) -> None:
        self.vector_size = len(items_of(self.vector_in))
