"""Poses of boxes and cylinders of known size from depth, and which cluster is which object."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import BtManipError
from bt_manip.spatial import pose, quat_wxyz

from .frame import Frame
from .segmentation import Circle, Cluster, Rectangle, find_clusters, refine_circle, refine_rectangle

SIZE_TOLERANCE = 6e-3
"""Largest difference of a measured size from that of an object at 0.65 m and closer [m]."""

COLOUR_TOLERANCE = 25.0
"""Largest angle between a seen colour and that of an object [degrees]."""

CLEARER = 8.0
"""Angle by which a colour must be nearer to that of an object than to those of others [degrees]."""

SQUARE = 4e-3
"""Difference of the sides of a box below which a quarter turn of it looks the same [m]."""


class NotSeenError(BtManipError):
    """No cluster, or more than one, can be an object."""


@dataclass(frozen=True)
class KnownObject:
    """What is known of an object that is looked for: a box or an upright cylinder.

    Attributes:
        name: Its name.
        shape: ``"box"`` or ``"cylinder"``.
        size: Of a box along its x, y and z axes; of a cylinder its diameter, twice, and its height
            [m].  # (3,)
        colour: Red, green, blue from 0 to 1; None where it is not known.
    """

    name: str
    shape: str
    size: tuple[float, float, float]
    colour: tuple[float, float, float] | None = None

    def top(self) -> np.ndarray:
        """Return the corners of its top in the frame of its centre [m]."""
        length, width, height = self.size
        origin = np.zeros(2)
        shape: Rectangle | Circle = Rectangle(origin, 0.0, (length, width))
        if self.shape == "cylinder":
            shape = Circle(origin, length)
        xy = shape.corners()
        return np.column_stack([xy, np.full(len(xy), height / 2.0)])  # (n, 3)


@dataclass(frozen=True)
class Estimate:
    """The estimated pose of an object.

    Attributes:
        name: Name of the object.
        T_wo: Pose of its centre in the world, or of its origin, upright. The yaw of a cylinder is
            0; that of a box is known up to the half turn, or the quarter turn of a square one,
            under which it looks the same: it is the one nearest to 0.
        position_error: Estimated standard deviation of its position: 0.75 pixels, and a quarter of
            the difference of the seen size from the known one [m].
        yaw_error: Estimated standard deviation of its yaw, 0 for a cylinder [rad].
        time: Simulated time of the exposure [s].
        camera: Name of the camera; empty where it is not known.
    """

    name: str
    T_wo: pin.SE3
    position_error: float
    yaw_error: float
    time: float
    camera: str = ""

    def plain(self) -> list[Any]:
        """Return it as plain data."""
        T_wo, rest = self.T_wo, (self.position_error, self.yaw_error, self.time, self.camera)
        return [self.name, *T_wo.translation.tolist(), *quat_wxyz(T_wo).tolist(), *rest]


def estimate_of(plain: Sequence[Any]) -> Estimate:
    """Return the estimate of which `Estimate.plain` returned this."""
    return Estimate(plain[0], pose(plain[1:4], plain[4:8]), *plain[8:])


def describe(cluster: Cluster) -> str:
    """Return what a cluster looks like, for messages."""
    x, y = cluster.middle
    cut = ", cut by the image's border" if cluster.at_border else ""
    return f"{sides_of(cluster)} at ({x:.3f}, {y:.3f}) m{cut}"


def sides_of(cluster: Cluster) -> str:
    """Return the size of a cluster as text."""
    sides = *cluster.rectangle.size, cluster.height
    return f"{' x '.join(f'{1e3 * side:.0f}' for side in sides)} mm"


def instead(clusters: Sequence[Cluster], known: KnownObject) -> str:
    """Return a message that an object is not seen, with the clusters and why none of them is it."""
    seen = (f"{describe(one)} ({why_not(one, known)})" for one in clusters)
    return f"'{known.name}' is not seen; seen is {'; '.join(seen) or 'nothing'}"


def why_not(cluster: Cluster, known: KnownObject) -> str:
    """Return why a cluster cannot be an object; empty if it can.

    Args:
        cluster: The cluster.
        known: The object.
    """
    if cluster.at_border:
        return "it is cut by the image's border"
    if known.colour is not None:
        between = _angle(cluster.colour, np.array(known.colour))
        if between > COLOUR_TOLERANCE:
            return f"its colour is {between:.0f} degrees away"
    tolerance = SIZE_TOLERANCE + 2.0 * cluster.pixel
    if abs(cluster.height - known.size[2]) > tolerance:
        return f"it is {1e3 * cluster.height:.0f} mm high"
    if known.shape == "cylinder":
        measured: tuple[float, ...] = (cluster.circle.diameter,)
        wanted: tuple[float, ...] = (known.size[0],)
        if not cluster.is_round:
            return "it is not round"
    else:
        measured = cluster.rectangle.size
        wanted = tuple(sorted(known.size[:2], reverse=True))
        if cluster.is_round:
            return "it is round"
    if any(abs(a - b) > tolerance for a, b in zip(measured, wanted, strict=True)):
        return f"its top is {' x '.join(f'{1e3 * side:.0f}' for side in measured)} mm"
    return ""


def name_clusters(
    clusters: Sequence[Cluster],
    objects: Sequence[KnownObject],
    believed: Mapping[str, np.ndarray] = MappingProxyType({}),
    gone: Collection[str] = (),
) -> tuple[dict[str, Cluster], dict[str, str]]:
    """Return the cluster of each object; objects that are not seen are left out.

    Objects keep their names where they were seen before: within their width, those that look alike
    within half of it. Elsewhere an object is only found if it was never seen before, or is gone
    from there, so that a look-alike is not taken for it. Objects that look alike are numbered by
    position, in the order of x, if all of them are seen and none was seen before. Nothing else is
    guessed: a cluster that fits objects which look different, more clusters than objects, and
    several that may have been exchanged are refused.

    Args:
        clusters: The clusters of a frame, in the order of x.
        objects: All objects that are looked for.
        believed: Where they were seen before, by name: x and y in the world [m].  # (2,)
        gone: Names of those that are not there any more.

    Returns:
        The clusters and the reasons of refusals, both by name of the object.
    """
    alike: dict[tuple[Any, ...], list[KnownObject]] = {}
    for one in objects:
        alike.setdefault((one.shape, one.size, one.colour), []).append(one)
    groups = list(alike.values())
    fits: list[list[int]] = [[] for _ in groups]
    for i, cluster in enumerate(clusters):
        for k in _nearest_colours(cluster, [group[0] for group in groups]):
            fits[k].append(i)
    named: dict[str, Cluster] = {}
    refused: dict[str, str] = {}
    for group, found in zip(groups, fits, strict=True):
        names = [one.name for one in group]
        shared = [i for i in found if sum(i in other for other in fits) > 1]
        if shared:
            both = [other[0].name for other, i in zip(groups, fits, strict=True) if shared[0] in i]
            reason = f"{_listed(both)} look like the same thing: {describe(clusters[shared[0]])}"
            refused |= dict.fromkeys(names, reason)
            continue
        reason = _name_alike(group, {i: clusters[i] for i in found}, believed, gone, named)
        if reason:
            refused |= dict.fromkeys(names, reason)
    return named, refused


def _nearest_colours(cluster: Cluster, objects: Sequence[KnownObject]) -> list[int]:
    """Return the indices of objects that a cluster can be, but for those of a farther colour."""
    found = [k for k, one in enumerate(objects) if not why_not(cluster, one)]
    away = {
        k: _angle(cluster.colour, np.array(colour))
        for k in found
        if (colour := objects[k].colour) is not None
    }
    limit = min(away.values(), default=0.0) + CLEARER
    return [k for k in found if away.get(k, 0.0) < limit]


def _name_alike(
    group: Sequence[KnownObject], found: dict[int, Cluster], believed: Mapping[str, np.ndarray],
    gone: Collection[str], named: dict[str, Cluster],
) -> str:  # fmt: skip
    """Name the clusters of objects that look alike; return why they cannot be named."""
    names = [one.name for one in group]
    near = min(group[0].size[:2]) * (1.0 if len(names) == 1 else 0.5)
    seen = "; ".join(map(describe, found.values()))
    kept: dict[str, int] = {}
    for name in names:
        for i, cluster in found.items():
            if name in believed and np.linalg.norm(cluster.middle - believed[name]) < near:
                kept[name] = i
    rest = [i for i in found if i not in kept.values()]
    new = [name for name in names if name not in believed]
    open_ = [name for name in names if name in new or (name in gone and name not in kept)]
    if len(rest) > len(open_) or len(set(kept.values())) < len(kept):
        if len(found) <= len(names):
            return f"{_listed(names)} may be what looks the same elsewhere: {seen}"
        return f"{len(found)} things look like {_listed(names)}: {seen}"
    if rest and open_ != new and len(open_) > 1:
        return f"{_listed(open_)} look alike, and may have been exchanged: {seen}"
    if rest and len(rest) < len(open_):
        return f"{_listed(open_)} look like the same thing: {seen}"
    named |= {name: found[i] for name, i in (*kept.items(), *zip(open_, rest, strict=False))}
    return ""


def _listed(names: Sequence[str]) -> str:
    return " and ".join(f"'{name}'" for name in names)


def fit_pose(cluster: Cluster, known: KnownObject, time: float) -> Estimate:
    """Return the pose of an object whose cluster is known.

    Args:
        cluster: Its cluster.
        known: The object.
        time: Time of the exposure [s].
    """
    length, width, height = known.size
    z = cluster.surface + height / 2.0
    if known.shape == "cylinder":
        circle = cluster.circle
        fitted = refine_circle(cluster.top, Circle(circle.centre, length))
        misfit, yaw, yaw_error = circle.diameter - length, 0.0, 0.0
        x, y = fitted.centre
    else:
        found = cluster.rectangle
        long, short = max(length, width), min(length, width)
        refined = refine_rectangle(cluster.top, Rectangle(found.centre, found.yaw, (long, short)))
        misfit = max(abs(found.size[0] - long), abs(found.size[1] - short))
        yaw = refined.yaw - (0.0 if length >= width else np.pi / 2.0)
        turn = np.pi / 2.0 if abs(length - width) < SQUARE else np.pi
        yaw = (yaw + turn / 2.0) % turn - turn / 2.0
        x, y = refined.centre
        yaw_error = float(np.arctan2(0.5 * cluster.pixel + 0.25 * misfit, long / 2.0))
    error = float(np.hypot(0.75 * cluster.pixel, 0.25 * misfit))
    T_wo = pin.SE3(pin.utils.rotate("z", yaw), np.array([x, y, z]))
    return Estimate(known.name, T_wo, error, yaw_error, time)


def estimate_pose(
    frame: Frame,
    known: KnownObject,
    *,
    others: Sequence[KnownObject] = (),
    surface: float | None = None,
) -> Estimate:
    """Estimate the pose of a box or an upright cylinder of known size that stands on a surface.

    Args:
        frame: The frame.
        known: The object.
        others: Other objects that may be there, for which it must not be taken.
        surface: Height of the surface in the world; None takes that of the largest one [m].

    Raises:
        NotSeenError: If nothing looks like it, or it cannot be told from something else; the
            message says what was seen.
    """
    clusters = find_clusters(frame, surface)
    found, refused = name_clusters(clusters, [known, *others])
    if known.name in refused:
        raise NotSeenError(refused[known.name])
    if known.name not in found:
        raise NotSeenError(instead(clusters, known))
    return fit_pose(found[known.name], known, frame.time)


def _angle(one: np.ndarray, other: np.ndarray) -> float:
    """Return the angle between two colours as vectors, which lighting does not change [degrees]."""
    length = np.linalg.norm(one) * np.linalg.norm(other)
    if length < 1e-9:
        return 180.0
    return float(np.degrees(np.arccos(min(one @ other / length, 1.0))))
