"""Grasp candidates: tool poses relative to an object, with their costs."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from bt_manip import spatial


@dataclass(frozen=True, eq=False)
class GraspCandidate:
    """Pose of the tool relative to an object when the gripper closes on it.

    Attributes:
        T_ot: Pose of the tool in the object's frame; its z axis is the approach direction.
        width: Gripped width [m].
        costs: Cost of each criterion that depends only on gripper and object [-].
    """

    T_ot: pin.SE3
    width: float
    costs: Mapping[str, float] = field(default_factory=dict)

    def to_text(self) -> str:
        """Return the candidate as ``x;y;z;qw;qx;qy;qz;width``, with the pose `T_ot`."""
        numbers = (*self.T_ot.translation, *spatial.quat_wxyz(self.T_ot), self.width)
        return ";".join(repr(float(x)) for x in numbers)

    @classmethod
    def from_text(cls, text: str) -> "GraspCandidate":
        """Parse text returned by `to_text`; it does not include the costs.

        Raises:
            ValueError: If it is not eight finite numbers, the last nonnegative.
        """
        try:
            numbers = [float(part) for part in text.split(";")]
        except ValueError:
            numbers = []
        if len(numbers) != 8 or not np.isfinite(numbers).all() or numbers[7] < 0.0:
            raise ValueError(f"a grasp is 'x;y;z;qw;qx;qy;qz;width' in metres, got '{text}'")
        return cls(spatial.pose(numbers[:3], numbers[3:7]), numbers[7])


@dataclass(frozen=True, eq=False)
class GraspCandidates:
    """The grasp candidates of one object as arrays, one row per candidate.

    Attributes:
        rotation: Rotation matrix of the tool in the object's frame.  # (n, 3, 3)
        position: Position of the tool in the object's frame [m].  # (n, 3)
        width: Gripped width [m].  # (n,)
        opening: Opening of the gripper just before contact: 1 for open, 0 for closed.  # (n,)
        costs: Cost of each criterion, from 0 to its weight [-].  # {criterion: (n,)}
        clear: Whether the gripper is known to touch the object at the contacts only; otherwise it
            is checked from fully open to `opening`.
        free_axis: Unit axis in the object's frame about which the tool may be turned from each
            candidate, for the same grasp; None where there are none.  # (n, 3)
        pivot: A point of each axis in the object's frame [m].  # (n, 3)
        closing: Unit direction between two fingers in the tool's frame; None: not of two.  # (3,)
    """

    rotation: np.ndarray
    position: np.ndarray
    width: np.ndarray
    opening: np.ndarray
    costs: Mapping[str, np.ndarray]
    clear: bool = False
    free_axis: np.ndarray | None = None
    pivot: np.ndarray | None = None
    closing: np.ndarray | None = None

    def __getitem__(self, i: int) -> GraspCandidate:
        """Return one candidate."""
        T_ot = pin.SE3(self.rotation[i].copy(), self.position[i].copy())
        costs = {name: float(column[i]) for name, column in self.costs.items()}
        return GraspCandidate(T_ot, float(self.width[i]), costs)

    def __len__(self) -> int:
        """Return the number of candidates."""
        return len(self.width)

    def __iter__(self) -> Iterator[GraspCandidate]:
        """Iterate over the candidates."""
        return (self[i] for i in range(len(self)))
