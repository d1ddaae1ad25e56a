"""Leaves that work on lists."""

from bt_manip.bt import InOut, Input, Output
from bt_manip.exceptions import PortError
from bt_manip_moveit_pro.leaf import Leaf


def items_of(value: object) -> list[object]:
    """Return the items of a list.

    Raises:
        ValueError: If it is none.
    """
    if isinstance(value, str) and not value:
        return []
    if not isinstance(value, list | tuple):
        raise ValueError(f"a list is expected, not {type(value).__name__}")
    return list(value)


class ResetVector(Leaf):
    """Write an empty list."""

    vector = Output(doc="the list")

    def run(self) -> None:
        """Write it."""
        self.vector = []


class ResetPoseStampedVector(ResetVector):
    """Write an empty list for poses."""


class VectorLeaf(Leaf):
    """A leaf that writes a changed copy of a list."""

    input_vector = Input(default="", doc="the list")
    output_vector = Output(doc="the changed list")

    def run(self) -> None:
        """Write the changed list."""
        items = items_of(self.input_vector)
        self.change(items)
        self.output_vector = items

    def change(self, items: list[object]) -> None:
        """Change the items in place."""
        raise NotImplementedError

    def place(self, items: list[object]) -> int:
        """Return the index of the port.

        Raises:
            ValueError: If there is no item at it.
        """
        index = int(self.read_port("index"))
        if not 0 <= index < len(items):
            raise ValueError(f"there is no item {index} among {len(items)}")
        return index


class PushBackVector(VectorLeaf):
    """Append an item to a list."""

    element = Input(doc="the item")

    def change(self, items: list[object]) -> None:
        """Append it."""
        items.append(self.element)


class InsertInVector(PushBackVector):
    """Insert an item into a list."""

    index = Input(int, doc="index of the item, from 0")

    def change(self, items: list[object]) -> None:
        """Insert it."""
        index = self.index
        if not 0 <= index <= len(items):
            raise ValueError(f"nothing can be inserted at {index} among {len(items)}")
        items.insert(index, self.element)


class ReplaceInVector(PushBackVector):
    """Replace an item of a list."""

    index = Input(int, doc="index of the item, from 0")

    def change(self, items: list[object]) -> None:
        """Replace it."""
        items[self.place(items)] = self.element


class RemoveFromVector(VectorLeaf):
    """Remove an item of a list."""

    index = Input(int, doc="index of the item, from 0")

    def change(self, items: list[object]) -> None:
        """Remove it."""
        del items[self.place(items)]


class ReversePoseStampedVector(VectorLeaf):
    """Reverse a list."""

    def change(self, items: list[object]) -> None:
        """Reverse it."""
        items.reverse()


class AddPoseStampedToVector(Leaf):
    """Append a pose to a list, which is made if there is none."""

    pose = Input(name="input", doc="the pose")
    vector = InOut(doc="the list")

    def run(self) -> None:
        """Append it."""
        try:
            items = items_of(self.vector)
        except PortError:
            items = []
        self.vector = [*items, self.pose]


class GetElementOfVector(Leaf):
    """Get an item of a list."""

    vector_in = Input(doc="the list")
    index = Input(int, default=0, doc="index of the item, from 0")
    element = Output(doc="the item")

    def run(self) -> None:
        """Write the item."""
        items, index = items_of(self.vector_in), self.index
        if not 0 <= index < len(items):
            raise ValueError(f"there is no item {index} among {len(items)}")
        self.element = items[index]


class GetSizeOfVector(Leaf):
    """Count the items of a list."""

    vector_in = Input(doc="the list")
    vector_size = Output(int, doc="the number of its items")

    def run(self) -> None:
        """Write the number."""
        self.vector_size = len(items_of(self.vector_in))
