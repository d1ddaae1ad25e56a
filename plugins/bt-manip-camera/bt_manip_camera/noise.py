"""The errors of depth cameras."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from bt_manip.parameters import Parameter

REFERENCE = 0.65
"""Depth to which the standard deviations refer, from which they grow with its square [m]."""

EDGE = 0.01
"""Change of depth from pixel to pixel that makes an edge [m]."""

CELLS = (4, 5)
"""Number of independent values of the smooth error over the image, along y and x."""


@dataclass(frozen=True)
class DepthErrors:
    """The errors of depth images, and of what is known of the camera.

    Attributes:
        noise: Standard deviation of each pixel, at the depth `REFERENCE` [m].
        smooth_noise: Standard deviation of an error that varies slowly over the image and is
            different in each frame, at the depth `REFERENCE` [m].
        bias: Added to all depths [m].
        dropout: Fraction of the pixels at edges without a depth.
        calibration_distance: Distance of the camera's believed position from the true one [m].
        calibration_angle: Angle between its believed and its true orientation [degrees].
    """

    noise: float = 1.5e-3
    smooth_noise: float = 2e-3
    bias: float = 0.0
    dropout: float = 0.5
    calibration_distance: float = 0.0
    calibration_angle: float = 0.0

    def corrupt(self, depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return a depth image with errors; 0 where the depth is unknown.

        Args:
            depth: The true one [m].  # (height, width)
            rng: From which the errors are drawn.
        """
        from scipy import ndimage  # takes half a second, and each command loads this module

        grid = rng.normal(size=CELLS)
        sizes = zip(CELLS, depth.shape, strict=True)
        at = np.meshgrid(*(np.linspace(0.0, n - 1.0, m) for n, m in sizes), indexing="ij")
        smooth = ndimage.map_coordinates(grid, at, order=1)
        each = rng.normal(size=depth.shape)
        scale = (depth / REFERENCE) ** 2
        wrong = depth + self.bias + scale * (self.noise * each + self.smooth_noise * smooth)
        down, across = np.gradient(depth)
        edge = ndimage.binary_dilation(np.hypot(down, across) > EDGE)
        lost = edge & (rng.random(depth.shape) < self.dropout)
        return np.where(lost | (depth <= 0.0), 0.0, wrong)

    def calibration_error(self, rng: np.random.Generator) -> pin.SE3:
        """Return the believed pose of the camera in its true frame, in a random direction."""
        drawn = rng.normal(size=(2, 3))
        along, about = drawn / np.linalg.norm(drawn, axis=1, keepdims=True)
        angle = np.radians(self.calibration_angle)
        return pin.SE3(pin.exp3(angle * about), self.calibration_distance * along)


PARAMETERS = {
    "noise": Parameter(
        "Standard deviation of the depth of each pixel at 0.65 m; it grows with the square of the "
        "depth", "m", DepthErrors.noise, at_least=0.0,
    ),
    "smooth_noise": Parameter(
        "Standard deviation, at 0.65 m, of an error of the depth that varies slowly over the image "
        "and is another one in each frame", "m", DepthErrors.smooth_noise, at_least=0.0,
    ),
    "bias": Parameter("Added to all depths", "m", DepthErrors.bias),
    "dropout": Parameter(
        "Fraction of the pixels at edges without a depth", "", DepthErrors.dropout, at_least=0.0,
        at_most=1.0,
    ),
    "calibration_distance": Parameter(
        "Distance of the believed position of the camera from the true one, in a random direction",
        "m", DepthErrors.calibration_distance, at_least=0.0,
    ),
    "calibration_angle": Parameter(
        "Angle between the believed and the true orientation of the camera, about a random axis",
        "degrees", DepthErrors.calibration_angle, at_least=0.0, at_most=180.0,
    ),
}  # fmt: skip
"""Parameters of cameras, by the fields of `DepthErrors`."""
