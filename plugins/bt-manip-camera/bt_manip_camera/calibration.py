"""Hand-eye calibration: where a camera is on the tool of a robot, from a tag that it sees."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

from bt_manip.cell import CellError, looking_at
from bt_manip.exceptions import MotionError

from .camera import DepthCamera
from .tags import SeenTag, detect_tags

FEWEST = 5
"""Fewest views from which a calibration is computed."""

TURN = 10.0
"""Smallest angle between two views that count for the first estimate [degrees]."""


class View(NamedTuple):
    """A tag seen from one configuration.

    Attributes:
        T_wg: Pose of the tool in the world, from the measured joint positions.
        T_ct: Pose of the tag in the frame of the camera, which looks along -z with y up.
        corners: The corners of the tag's black square, as of `SeenTag`, from the image's centre to
            the right and up, as a fraction of the focal length.  # (4, 2)
    """

    T_wg: pin.SE3
    T_ct: pin.SE3
    corners: np.ndarray


@dataclass(frozen=True)
class HandEye:
    """The calibration of a camera on a tool.

    Attributes:
        T_gc: Pose of the camera in the frame of the tool.
        T_wt: Pose of the tag in the world.
        residual: Root mean square of the distance of a corner from where it is expected, as a
            fraction of the focal length.
        views: Number of views.
    """

    T_gc: pin.SE3
    T_wt: pin.SE3
    residual: float
    views: int


def calibrate(views: Sequence[View], size: float) -> HandEye:
    """Compute where a camera is on its tool.

    The first estimate is the closed form of Park and Martin (1994) for the motions between all
    pairs of views; the reprojection of the corners is then minimized over the poses of camera and
    tag.

    Args:
        views: The views, from configurations that differ by rotations about several axes.
        size: Length of the sides of the black square [m].

    Raises:
        CellError: If there are too few views, or all rotations are about one axis.
    """
    if len(views) < FEWEST:
        raise CellError(f"a calibration needs at least {FEWEST} views of the tag, not {len(views)}")
    T_gc = park_martin([one.T_wg for one in views], [one.T_ct for one in views])
    poses = [one.T_wg * T_gc * one.T_ct for one in views]
    T_wt = poses[int(np.argmin([_spread(T, poses) for T in poses]))]
    square = 0.5 * size * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])

    def residuals(x: np.ndarray) -> np.ndarray:
        T_g, T_w = T_gc * pin.exp6(x[:6]), T_wt * pin.exp6(x[6:])
        found = []
        for one in views:
            T_ct = (one.T_wg * T_g).actInv(T_w)
            points = square @ T_ct.rotation.T + T_ct.translation
            found.append(points[:, :2] / -points[:, 2:] - one.corners)
        return np.ravel(found)

    fit = least_squares(residuals, np.zeros(12), x_scale=0.01, xtol=1e-12, ftol=1e-12)
    rms = float(np.sqrt(2.0 * fit.cost / (4 * len(views))))
    return HandEye(T_gc * pin.exp6(fit.x[:6]), T_wt * pin.exp6(fit.x[6:]), rms, len(views))


def park_martin(tools: Sequence[pin.SE3], tags: Sequence[pin.SE3]) -> pin.SE3:
    """Return the pose of the camera in the tool, from A X = X B for the motions A and B.

    Park and Martin, Robot sensor calibration: solving AX = XB on the Euclidean group, IEEE
    Transactions on Robotics and Automation 10(5), 1994.

    Args:
        tools: Poses of the tool in the world.
        tags: Poses of the tag in the camera, as many.

    Raises:
        CellError: If all rotations are about one axis.
    """
    moves = [
        (tools[j].actInv(tools[i]), tags[j] * tags[i].inverse())
        for i in range(len(tools))
        for j in range(i)
    ]
    moves = [(a, b) for a, b in moves if np.linalg.norm(pin.log3(a.rotation)) > np.radians(TURN)]
    turns = np.array([[pin.log3(a.rotation), pin.log3(b.rotation)] for a, b in moves])
    if not len(turns) or np.linalg.svd(turns[:, 0])[1][1] < np.radians(TURN):
        raise CellError("a calibration needs views from rotations about at least two axes")
    left, _, right = np.linalg.svd(turns[:, 0].T @ turns[:, 1])
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    R = left @ sign @ right
    matrix = np.vstack([a.rotation - np.eye(3) for a, _ in moves])
    wanted = np.concatenate([R @ b.translation - a.translation for a, b in moves])
    return pin.SE3(R, np.linalg.lstsq(matrix, wanted, rcond=None)[0])


def difference(T: pin.SE3, other: pin.SE3) -> tuple[float, float]:
    """Return the distance [m] and the angle [rad] between two poses."""
    off = T.actInv(other)
    return float(np.linalg.norm(off.translation)), float(np.linalg.norm(pin.log3(off.rotation)))


def take_views(
    station: Any, camera: DepthCamera, *, number: int, tag: int, size: float, at: np.ndarray
) -> Iterator[View]:
    """Look at a tag from several configurations.

    Args:
        station: The station; its arm moves.
        camera: The camera, on the tool of a robot.
        number: Number of views.
        tag: Number of the tag.
        size: Length of the sides of its black square [m].
        at: About where it is in the world [m].  # (3,)

    Yields:
        The views; configurations out of reach and those from which the tag is not seen are left
        out.

    Raises:
        CellError: If the camera is on no robot.
    """
    if not camera.mount:
        raise CellError("a camera that is calibrated is on the tool of a robot")
    arm, robot = station.robots[camera.mount].arm, station.robots[camera.mount].robot
    rng, taken, tried = station.rng, 0, 0
    while taken < number and tried < 5 * number:
        tried += 1
        frame = camera.expose(rng, station.robots)
        T_gc = arm.model.pose(robot.q).actInv(frame.T_wc)  # as it is believed
        azimuth, elevation = rng.uniform(-np.pi, np.pi), np.radians(rng.uniform(45.0, 85.0))
        flat = np.cos(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])
        eye = at + rng.uniform(0.25, 0.4) * np.append(flat, np.sin(elevation))
        roll = pin.SE3(pin.utils.rotate("z", rng.uniform(-np.pi, np.pi)), np.zeros(3))
        target = at + np.append(rng.uniform(-0.04, 0.04, 2), 0.0)
        try:
            arm.move_to_pose([looking_at(eye, target) * roll * T_gc.inverse()])
            station.step_until(lambda: arm.at_rest, timeout=20.0, steps=10)
        except (MotionError, TimeoutError):
            continue
        frame = camera.expose(rng, station.robots)
        for one in detect_tags(frame, size):
            if one.number == tag:
                taken += 1
                yield view_of(one, frame, arm.model.pose(robot.q))


def view_of(one: SeenTag, frame: Any, T_wg: pin.SE3) -> View:
    """Return the view of a tag in a frame, taken with the tool at a pose."""
    height, width = frame.depth.shape
    corners = (one.corners - (width / 2.0, height / 2.0)) / frame.focal_length
    return View(T_wg, frame.T_wc.actInv(one.T_wt), corners * (1.0, -1.0))


def _spread(T: pin.SE3, poses: Sequence[pin.SE3]) -> float:
    return sum(float(np.linalg.norm(T.translation - other.translation)) for other in poses)
