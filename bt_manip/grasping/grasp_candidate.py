"""Grasp candidates: tool poses relative to an object."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from bt_manip import spatial


@dataclass(frozen=True, eq=False)
class GraspCandidate:
    """Pose of the tool relative to an object when the fingers close on it.

    The approach direction is the tool's z axis.

    Attributes:
        T_ot: Pose of the tool in the object's frame.
        width: Distance between the two contact points [m].
        closing: Direction from one finger to the other, in the object's frame; unit.  # (3,)
        contact: Fraction of the pads in contact with the object, 0 to 1.
        normal_angle: Largest angle between the closing direction and a surface normal [rad].
        depth_loss: How far palm or fingertips keep the tool short of the preferred depth [m].
    """

    T_ot: pin.SE3
    width: float
    closing: np.ndarray
    contact: float = 1.0
    normal_angle: float = 0.0
    depth_loss: float = 0.0

    @property
    def approach(self) -> np.ndarray:
        """Approach direction in the object's frame; unit."""  # (3,)
        return np.array(self.T_ot.rotation[:, 2])

    def to_text(self) -> str:
        """Return it as ``x;y;z;qw;qx;qy;qz;width``, the pose being `T_ot`."""
        numbers = (*self.T_ot.translation, *spatial.quat_wxyz(self.T_ot), self.width)
        return ";".join(repr(float(x)) for x in numbers)

    @classmethod
    def from_text(cls, text: str) -> "GraspCandidate":
        """Parse the text that `to_text` returns; the closing direction is not part of it.

        Raises:
            ValueError: When it is not eight finite numbers, the last not negative.
        """
        try:
            numbers = [float(part) for part in text.split(";")]
        except ValueError:
            numbers = []
        if len(numbers) != 8 or not np.isfinite(numbers).all() or numbers[7] < 0.0:
            raise ValueError(f"a grasp is 'x;y;z;qw;qx;qy;qz;width' in metres, got '{text}'")
        return cls(spatial.pose(numbers[:3], numbers[3:7]), numbers[7], np.zeros(3))


@dataclass(frozen=True, eq=False)
class GraspTable:
    """The grasp candidates of one object as arrays, one row per candidate.

    The attributes are those of `GraspCandidate`, with `T_ot` as rotation and position.
    """

    rotation: np.ndarray  # (n, 3, 3)
    position: np.ndarray  # (n, 3)
    width: np.ndarray  # (n,)
    closing: np.ndarray  # (n, 3)
    contact: np.ndarray  # (n,)
    normal_angle: np.ndarray  # (n,)
    depth_loss: np.ndarray  # (n,)

    def __getitem__(self, i: int) -> GraspCandidate:
        """Return one candidate."""
        return GraspCandidate(
            pin.SE3(self.rotation[i].copy(), self.position[i].copy()),
            float(self.width[i]),
            self.closing[i].copy(),
            float(self.contact[i]),
            float(self.normal_angle[i]),
            float(self.depth_loss[i]),
        )

    def __len__(self) -> int:
        """Return the number of candidates."""
        return len(self.width)

    def __iter__(self) -> Iterator[GraspCandidate]:
        """Iterate over the candidates."""
        return (self[i] for i in range(len(self)))
