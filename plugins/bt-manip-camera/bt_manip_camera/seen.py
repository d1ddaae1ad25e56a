"""Seen poses: what the tree believes, where cameras have seen something."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import pinocchio as pin

from bt_manip.cell import CellError
from bt_manip.scenes import PoseSource, SceneObject
from bt_manip.spatial import pose, quat_wxyz

from .believed import BelievedCell
from .estimation import Estimate


@dataclass(frozen=True)
class SeenPose:
    """The believed pose of an object.

    Attributes:
        T_wo: Pose of its origin in the world when it was last seen.
        time: Simulated time of the exposure [s].
        position_error: Estimated standard deviation of its position [m].
        yaw_error: Estimated standard deviation of its yaw [rad].
        camera: Name of the camera.
    """

    T_wo: pin.SE3
    time: float
    position_error: float
    yaw_error: float
    camera: str


class SeenPoses(PoseSource):
    """Expected objects are where a camera has last seen them; unseen ones are absent.

    Behaviours such as `WaitUntilSeen` report what they see by `report`.

    Args:
        expected: The expected objects.

    Attributes:
        seen: What was last seen of each object, by name.
        lost: Names of objects that are not any more where they were last seen.
        look: Looks for an object with the cameras where they are, given its name and a pose of its
            height, and reports it; raises a `CellError` when it was not seen for a while.
    """

    believed_cell = BelievedCell

    def __init__(self, expected: Any) -> None:
        super().__init__(expected)
        self.look: Callable[[str, pin.SE3], None] = not_seen
        self.seen: dict[str, SeenPose] = {}
        self.lost: set[str] = set()

    def report(self, name: str, T_wo: pin.SE3, found: Estimate, camera: str) -> None:
        """Note where an object was seen.

        Args:
            name: Its name.
            T_wo: Pose of its origin.
            found: The estimate, of its centre.
            camera: Name of the camera.
        """
        self.seen[name] = SeenPose(T_wo, found.time, found.position_error, found.yaw_error, camera)
        self.lost.discard(name)

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
        return dict.fromkeys(sorted(self.lost)) | {
            name: [
                *one.T_wo.translation.tolist(), *quat_wxyz(one.T_wo).tolist(), one.time,
                one.position_error, one.yaw_error, one.camera,
            ]
            for name, one in self.seen.items()
        }  # fmt: skip

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore what `get_state` returned."""
        self.seen = {
            name: SeenPose(pose(values[:3], values[3:7]), *values[7:])
            for name, values in state.items()
            if values is not None
        }
        self.lost = {name for name, values in state.items() if values is None}


def not_seen(name: str, T_wo: pin.SE3) -> None:
    """Refuse to wait for an object.

    Raises:
        CellError: Always.
    """
    raise CellError(f"'{name}' was not seen: look first, by WaitUntilSeen")
