"""Frames: what a camera saw at one time."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin


class Frame(NamedTuple):
    """The depth and colour images of a camera, which looks along its -z axis with y up.

    Attributes:
        depth: Distance of each pixel along the camera's axis; 0 where it is unknown
            [m].  # (height, width)
        colour: Red, green and blue from 0 to 255, the top row first.  # (height, width, 3) uint8
        focal_length: Of both axes; the principal point is the centre of the image [pixels].
        T_wc: Pose of the camera in the world as it is known, with the error of its calibration.
        time: Simulated time of the exposure [s].
    """

    depth: np.ndarray
    colour: np.ndarray
    focal_length: float
    T_wc: pin.SE3
    time: float = 0.0

    def rays(self) -> np.ndarray:
        """Return the points of all pixels at depth 1 in the camera's frame [m]."""
        height, width = self.depth.shape
        x = (np.arange(width) + 0.5 - 0.5 * width) / self.focal_length
        y = (0.5 * height - 0.5 - np.arange(height)) / self.focal_length
        rays = np.full((height, width, 3), -1.0)
        rays[..., 0], rays[..., 1] = x, y[:, None]
        return rays  # (height, width, 3)

    def points(self, step: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """Return the seen points in the world, and their colours.

        Args:
            step: Take each pixel of so many in both directions.

        Returns:
            The points [m], and red, green and blue from 0 to 255.  # (n, 3), (n, 3) uint8
        """
        depth = self.depth[::step, ::step]
        seen = depth > 0.0
        local = self.rays()[::step, ::step][seen] * depth[seen][:, None]
        world = local @ self.T_wc.rotation.T + self.T_wc.translation
        return world, self.colour[::step, ::step][seen]

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Return where points of the world are in the image.

        Args:
            points: The points, in front of the camera [m].  # (n, 3)

        Returns:
            Their columns and rows; the corners of pixels are whole numbers [pixels].  # (n, 2)
        """
        height, width = self.depth.shape
        x, y, z = ((points - self.T_wc.translation) @ self.T_wc.rotation).T
        scale = self.focal_length / -z
        return np.column_stack([0.5 * width + scale * x, 0.5 * height - scale * y])


def focal_length(height: int, fovy: float) -> float:
    """Return the focal length of an image [pixels].

    Args:
        height: Its height [pixels].
        fovy: The vertical angle of view [degrees].
    """
    return 0.5 * height / float(np.tan(0.5 * np.radians(fovy)))


def difference(T: pin.SE3, other: pin.SE3) -> tuple[float, float]:
    """Return the distance [m] and the angle [rad] between two poses."""
    off = T.actInv(other)
    return float(np.linalg.norm(off.translation)), float(np.linalg.norm(pin.log3(off.rotation)))
