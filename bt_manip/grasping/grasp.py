"""Grasps of an object by two fingers."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from bt_manip import spatial


@dataclass(frozen=True, eq=False)
class Grasp:
    """Where the tool is, seen from an object, when the fingers close on it.

    The tool comes along its z axis.

    Attributes:
        T_ot: Pose of the tool in the object's frame.
        width: Distance between the places that the fingers touch [m].
        closing: Direction from one finger to the other, in the object's frame; unit.  # (3,)
        contact: Share of the pads that finds something to lie on, 0 to 1.
        slant: Largest angle between the closing direction and the normal of a face [rad].
        deeper: How much farther out than it would like to be the hand is kept by palm or tips [m].
    """

    T_ot: pin.SE3
    width: float
    closing: np.ndarray
    contact: float = 1.0
    slant: float = 0.0
    deeper: float = 0.0

    @property
    def approach(self) -> np.ndarray:
        """Direction that the tool comes in, in the object's frame; unit."""  # (3,)
        return np.array(self.T_ot.rotation[:, 2])

    def to_text(self) -> str:
        """Write it as ``x;y;z;qw;qx;qy;qz;width``, the pose that of the tool in the object."""
        numbers = (*self.T_ot.translation, *spatial.quat_wxyz(self.T_ot), self.width)
        return ";".join(repr(float(x)) for x in numbers)

    @classmethod
    def from_text(cls, text: str) -> "Grasp":
        """Read what `to_text` wrote; of the closing direction it knows nothing.

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
    """Many grasps of one object, as arrays: they are compared together.

    Attributes are those of `Grasp`, one row each; the tool's pose in the object is in two parts.
    """

    rotation: np.ndarray  # (n, 3, 3)
    position: np.ndarray  # (n, 3)
    width: np.ndarray  # (n,)
    closing: np.ndarray  # (n, 3)
    contact: np.ndarray  # (n,)
    slant: np.ndarray  # (n,)
    deeper: np.ndarray  # (n,)

    def __getitem__(self, i: int) -> Grasp:
        """Give one of them."""
        return Grasp(
            pin.SE3(self.rotation[i].copy(), self.position[i].copy()),
            float(self.width[i]),
            self.closing[i].copy(),
            float(self.contact[i]),
            float(self.slant[i]),
            float(self.deeper[i]),
        )

    def __len__(self) -> int:
        """Count them."""
        return len(self.width)

    def __iter__(self) -> Iterator[Grasp]:
        """Give one after the other."""
        return (self[i] for i in range(len(self)))
