"""The objects that a scene expects, as behaviours use them."""

from typing import Any, Protocol


class AwaitedObjects(Protocol):
    """Objects whose poses no simulation decides; `bt_manip.scenes.ExpectedObjects` is one."""

    def next(self, model: str = "") -> Any:
        """Return the next unused object, which has a ``name``; of any model if empty.

        Raises:
            CellError: If there is none.
        """

    def add(self, name: str) -> bool:
        """Add an object to the cell once its pose is known; return whether it was added.

        Raises:
            CellError: If it would penetrate something, or its pose cannot be known.
        """

    def taken(self, name: str) -> None:
        """Note that an object was taken away."""
