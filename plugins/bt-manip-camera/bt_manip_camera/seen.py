"""Seen poses: what the tree believes, where cameras have seen something."""

from collections.abc import Callable, Mapping
from typing import Any

import pinocchio as pin

from bt_manip.scenes import PoseSource, SceneObject

from .believed import BelievedCell
from .estimation import Estimate, estimate_of


class SeenPoses(PoseSource):
    """Expected objects are where a camera has last seen them; unseen ones are absent.

    Behaviours such as `WaitUntilSeen` report what they see by `report`.

    Args:
        expected: The expected objects.

    Attributes:
        seen: The last estimate of the origin of each object, by name.
        lost: Names of objects that are not any more where they were last seen.
        look: Looks for an object with the cameras where they are, given its name and a pose of its
            height, and reports it; raises a `CellError` when it was not seen for a while.
    """

    believed_cell = BelievedCell
    look: Callable[[str, pin.SE3], None]

    def __init__(self, expected: Any) -> None:
        super().__init__(expected)
        self.seen: dict[str, Estimate] = {}
        self.lost: set[str] = set()

    def report(self, found: Estimate) -> None:
        """Note where the origin of an object was seen."""
        self.seen[found.name] = found
        self.lost.discard(found.name)

    def lose(self, name: str) -> None:
        """Note that an object is not any more where it was last seen."""
        self.seen.pop(name, None)
        self.lost.add(name)

    def pose(self, scene_object: SceneObject, T_wo: pin.SE3) -> pin.SE3 | None:
        """Return where it was last seen; until it is, look.

        Raises:
            CellError: If it is not seen for a while: a tree that waits for it would wait for ever.
        """
        name = scene_object.name
        if name not in self.seen:
            self.look(name, T_wo)
        found = self.seen.get(name)
        return None if found is None else found.T_wo

    def taken(self, name: str) -> None:
        """Forget where an object was seen."""
        self.seen.pop(name, None)
        self.lost.discard(name)

    def get_state(self) -> dict[str, Any]:
        """Return the last sightings and the names of lost objects, as plain data."""
        seen = {name: one.plain() for name, one in self.seen.items()}
        return dict.fromkeys(sorted(self.lost)) | seen

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore what `get_state` returned."""
        self.seen = {n: estimate_of(values) for n, values in state.items() if values is not None}
        self.lost = {name for name, values in state.items() if values is None}
