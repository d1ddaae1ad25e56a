"""Hand-eye calibration: where a camera is, on a tool or fixed, from a tag that it sees.

A fixed camera (eye-to-hand) sees a tag on the hand. Then all poses of the tool in the world are
replaced by their inverses, and the same equations give the camera in the world and the tag on the
tool.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

from bt_manip.cell import CellError, looking_at
from bt_manip.exceptions import MotionError
from bt_manip.spatial import quat_wxyz

from .camera import DepthCamera
from .tags import SeenTag, Tag, detect_tags

FEWEST = 5
"""Fewest views from which a calibration is computed."""

HELD = pin.SE3(
    np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([0.07, 0, -0.05])
)
"""Pose of a tag on a hand in the frame of the tool: beside it, facing along the tool's x axis."""

TURN = 10.0
"""Smallest angle between two views that count for the first estimate [degrees]."""


class View(NamedTuple):
    """A tag seen from one configuration.

    Attributes:
        T_wg: Pose of the tool in the world, from the measured joint positions; for a fixed camera
            its inverse.
        T_ct: Pose of the tag in the frame of the camera, which looks along -z with y up.
        corners: The corners of the tag's black square, as of `SeenTag`, from the image's centre to
            the right and up, as a fraction of the focal length.  # (4, 2)
    """

    T_wg: pin.SE3
    T_ct: pin.SE3
    corners: np.ndarray


@dataclass(frozen=True)
class HandEye:
    """The calibration of a camera.

    Attributes:
        T_gc: Pose of the camera in the frame of the tool; that of a fixed one in the world.
        T_wt: Pose of the tag in the world; that on a hand in the frame of the tool.
        residual: Root mean square of the distance of a corner from where it is expected, as a
            fraction of the focal length.
        views: Number of views.
    """

    T_gc: pin.SE3
    T_wt: pin.SE3
    residual: float
    views: int


def calibrate(views: Sequence[View], size: float) -> HandEye:
    """Compute where a camera is.

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
    at = np.array([T.translation for T in poses])
    T_wt = poses[int(np.linalg.norm(at[:, None] - at, axis=2).sum(axis=1).argmin())]
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
    if not len(turns) or np.linalg.matrix_rank(turns[:, 0], np.radians(TURN)) < 2:
        raise CellError("a calibration needs views from rotations about at least two axes")
    left, _, right = np.linalg.svd(turns[:, 0].T @ turns[:, 1])
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    R = left @ sign @ right
    matrix = np.vstack([a.rotation - np.eye(3) for a, _ in moves])
    wanted = np.concatenate([R @ b.translation - a.translation for a, b in moves])
    return pin.SE3(R, np.linalg.lstsq(matrix, wanted, rcond=None)[0])


def hold_tag(station: Any, number: int, size: float) -> None:
    """Put a tag on the hand of the first robot, at `HELD`.

    Args:
        station: The station.
        number: Number of the tag.
        size: Length of the sides of its black square [m].
    """
    tag, robot = Tag(number=number, size=size), station.robot
    for geom in tag.mjcf_model.find_all("geom"):
        geom.contype = geom.conaffinity = 0
    body = tag.mjcf_model.find("body", "tag")
    body.pos, body.quat = HELD.translation, quat_wxyz(HELD)
    with station.cell.editing():
        robot.attach(tag, robot.tool_site)


def take_views(
    station: Any, camera: DepthCamera, *, number: int, tag: int, size: float, at: Any = None
) -> Iterator[View]:
    """See a tag from several configurations.

    Args:
        station: The station; its arm moves.
        camera: The camera, on the tool of a robot; or fixed, with the tag on the hand.
        number: Number of views.
        tag: Number of the tag.
        size: Length of the sides of its black square [m].
        at: About where it is in the world [m]; None: on the hand.  # (3,)

    Yields:
        The views; configurations out of reach and those from which the tag is not seen are left
        out.
    """
    one = station.robots[camera.mount] if camera.mount else station.first
    arm, robot = one.arm, one.robot
    rng, taken, tried = station.rng, 0, 0
    while taken < number and tried < 20 * number:
        tried += 1
        T_wc = camera.expose(rng, station.robots).T_wc  # as it is believed
        if camera.mount:
            T_wg = _looking(rng, at) * T_wc.inverse() * arm.model.pose(robot.q)
        else:
            T_wg = T_wc * _facing(rng, camera) * HELD.inverse()
        try:
            arm.move_to_pose([T_wg])
            station.step_until(lambda: arm.at_rest, timeout=20.0, steps=10)
        except (MotionError, TimeoutError):
            continue
        frame = camera.expose(rng, station.robots)
        for seen in detect_tags(frame, size):
            if seen.number == tag:
                taken += 1
                T_wg = arm.model.pose(robot.q)
                yield view_of(seen, frame, T_wg if camera.mount else T_wg.inverse())


def _looking(rng: np.random.Generator, at: np.ndarray) -> pin.SE3:
    """Return a random pose of a camera that looks at a point."""
    azimuth, elevation = rng.uniform(-np.pi, np.pi), np.radians(rng.uniform(45.0, 85.0))
    flat = np.cos(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])
    eye = at + rng.uniform(0.25, 0.4) * np.append(flat, np.sin(elevation))
    roll = pin.SE3(pin.utils.rotate("z", rng.uniform(-np.pi, np.pi)), np.zeros(3))
    return looking_at(eye, at + np.append(rng.uniform(-0.04, 0.04, 2), 0.0)) * roll


def _facing(rng: np.random.Generator, camera: DepthCamera) -> pin.SE3:
    """Return a random pose of a tag in the frame of a camera, within its image."""
    distance, about = rng.uniform(0.3, 1.0), rng.uniform(-np.pi, np.pi)
    half = 0.35 * np.array([camera.width, camera.height]) / camera.focal_length
    tilt = np.radians(rng.uniform(5.0, 40.0)) * np.array([np.cos(about), np.sin(about), 0.0])
    turn = pin.exp3(tilt) @ pin.utils.rotate("z", rng.uniform(-np.pi, np.pi))
    return pin.SE3(turn, distance * np.append(rng.uniform(-half, half), -1.0))


def view_of(one: SeenTag, frame: Any, T_wg: pin.SE3) -> View:
    """Return the view of a tag in a frame, taken at a pose as of `View`."""
    height, width = frame.depth.shape
    corners = (one.corners - (width / 2.0, height / 2.0)) / frame.focal_length
    return View(T_wg, frame.T_wc.actInv(one.T_wt), corners * (1.0, -1.0))
