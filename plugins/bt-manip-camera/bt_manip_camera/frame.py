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


def focal_length(height: int, fovy: float) -> float:
    """Return the focal length of an image [pixels].

    Args:
        height: Its height [pixels].
        fovy: The vertical angle of view [degrees].
    """
    return 0.5 * height / float(np.tan(0.5 * np.radians(fovy)))
