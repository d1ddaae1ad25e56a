"""Objects on a horizontal surface, found in depth images without trained weights."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .frame import Frame

LOWEST = 8e-3
"""Height above the surface from which points belong to objects [m]."""

HIGHEST = 0.25
"""Height above the surface up to which points belong to objects [m]."""

GRID = 6e-3
"""Distance of points above which they belong to different objects [m]."""

FEWEST = 60
"""Number of points from which a cluster is one."""

SURFACE_BAND = 0.02
"""Largest distance from the surface of points that are taken for it [m]."""

PLANE_WINDOW = 0.15
"""Distance from an object within which the surface corrects its depths [m]."""

DEPTH_NOISE = 1.5e-3
"""Assumed standard deviation of each pixel's depth at 0.65 m, growing with its square [m]."""

REACH = 4e-3
"""Distance outside an outline from which a point counts as an outlier [m]."""

MOST_POINTS = 2500
"""Number of points that an outline is fitted to at most."""

_ANGLES = np.radians(np.arange(0.0, 180.0, 10.0))
_DIRECTIONS = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])


@dataclass(frozen=True)
class Cluster:
    """What stands on a surface: the top of an object, seen from above or obliquely.

    Attributes:
        top: Points of its top in the world, x and y [m].  # (n, 2)
        height: Height of its top above the surface [m].
        surface: Height of the surface below it in the world [m].
        colour: Mean colour of its top: red, green, blue from 0 to 1.  # (3,)
        pixel: Width of a pixel at its top [m].
        at_border: Whether it touches the border of the image.
    """

    top: np.ndarray
    height: float
    surface: float
    colour: np.ndarray
    pixel: float
    at_border: bool = False

    @property
    def middle(self) -> np.ndarray:
        """Middle of its top in the world, x and y [m]."""
        return np.median(self.top, axis=0)  # (2,)

    @cached_property
    def rectangle(self) -> "Rectangle":
        """The smallest rectangle around its top."""
        return fit_rectangle(self.top)

    @cached_property
    def circle(self) -> "Circle":
        """The circle around its top."""
        return fit_circle(self.top)

    @cached_property
    def is_round(self) -> bool:
        """Whether its top is as wide in all directions; a square is 1.41 times as wide in some."""
        low, high = _bounds(self.top @ _DIRECTIONS.T)
        widths = high - low
        return bool(widths.max() < 1.2 * widths.min())


@dataclass(frozen=True)
class Rectangle:
    """A rectangle in the world's horizontal plane.

    Attributes:
        centre: Its centre, x and y [m].  # (2,)
        yaw: Angle from the world's x axis to its long side [rad].
        size: Its long and its short side [m].
    """

    centre: np.ndarray
    yaw: float
    size: tuple[float, float]

    def corners(self) -> np.ndarray:
        """Return its corners, x and y [m]."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        half = 0.5 * np.array(self.size) * ((1, 1), (-1, 1), (-1, -1), (1, -1))
        return self.centre + half @ np.array([[c, s], [-s, c]])  # (4, 2)


@dataclass(frozen=True)
class Circle:
    """A circle in the world's horizontal plane: centre, x and y, and diameter [m]."""

    centre: np.ndarray
    diameter: float

    def corners(self) -> np.ndarray:
        """Return the corners of a polygon in it, x and y [m]."""
        angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        around = np.column_stack([np.cos(angle), np.sin(angle)])
        return self.centre + 0.5 * self.diameter * around  # (24, 2)


def surface_height(z: np.ndarray) -> float | None:
    """Return the height of the largest horizontal surface; None where there is none [m].

    Args:
        z: Heights of points in the world [m].  # (n,)
    """
    if len(z) < FEWEST:
        return None
    bins = np.arange(z.min(), z.max() + 0.01, 0.005)
    counts, edges = np.histogram(z, bins)
    if counts.max() < FEWEST:
        return None
    near = edges[counts.argmax()] + 0.0025
    return float(np.median(z[np.abs(z - near) < 0.0075]))


def find_clusters(frame: Frame, surface: float | None = None) -> list[Cluster]:
    """Find what stands on a horizontal surface, in the order of x.

    The depths around each object are corrected so that the surface there has its height: an error
    that is common to both, such as a bias, then does not count.

    Args:
        frame: The frame.
        surface: Height of the surface in the world; None takes that of the largest one [m].
    """
    seen, rays = frame.depth > 0.0, frame.rays() @ frame.T_wc.rotation.T
    points = frame.T_wc.translation + rays * frame.depth[..., None]
    if surface is None:
        surface = surface_height(points[seen][:, 2])
        if surface is None:
            return []
    height = np.where(seen, points[..., 2] - surface, np.inf)
    above = (height > LOWEST) & (height < HIGHEST)
    if above.sum() < FEWEST:
        return []
    clusters = []
    for rows, columns in _groups(points, above):
        cluster = _cluster(frame, surface, rays, points, height, rows, columns)
        if cluster is not None:
            clusters.append(cluster)
    return sorted(clusters, key=lambda one: tuple(one.middle))


def _groups(points: np.ndarray, above: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the pixels, rows and columns, of each group of neighbouring points."""
    from scipy import ndimage  # takes half a second, and each command loads this module

    rows, columns = np.nonzero(above)
    xy = points[rows, columns, :2]
    low, high = np.percentile(xy, (0.1, 99.9), axis=0)
    low, high = np.maximum(xy.min(0), low - 0.3), np.minimum(xy.max(0), high + 0.3)
    inside = np.all((xy >= low) & (xy <= high), axis=1)
    rows, columns, xy = rows[inside], columns[inside], xy[inside]
    at = np.floor((xy - low) / GRID).astype(int)
    counts = np.zeros(at.max(0) + 1, int)
    np.add.at(counts, (at[:, 0], at[:, 1]), 1)
    labels, number = ndimage.label(counts >= 2, structure=np.ones((3, 3)))
    label = labels[at[:, 0], at[:, 1]]
    sizes = np.bincount(label)
    chosen = [k for k in range(1, number + 1) if sizes[k] >= FEWEST]
    return [(rows[label == k], columns[label == k]) for k in chosen]


def _cluster(
    frame: Frame, surface: float, rays: np.ndarray, points: np.ndarray, height: np.ndarray,
    rows: np.ndarray, columns: np.ndarray,
) -> Cluster | None:  # fmt: skip
    """Return the top of a group of pixels, with depths corrected by the surface around it."""
    eye = frame.T_wc.translation
    depth, xy = frame.depth[rows, columns], points[rows, columns, :2]
    low, high = xy.min(0) - PLANE_WINDOW, xy.max(0) + PLANE_WINDOW
    r0, r1 = max(rows.min() - 120, 0), rows.max() + 121
    c0, c1 = max(columns.min() - 120, 0), columns.max() + 121
    part = points[r0:r1:2, c0:c1:2]
    plane = np.abs(height[r0:r1:2, c0:c1:2]) < SURFACE_BAND
    plane &= np.all((part[..., :2] > low) & (part[..., :2] < high), axis=-1)
    if plane.sum() >= FEWEST:
        v, u = np.nonzero(plane)
        v, u = r0 + 2 * v, c0 + 2 * u
        error = frame.depth[v, u] - (surface - eye[2]) / rays[v, u, 2]
        centred, own = (
            np.column_stack([np.ones(len(x)), x - columns.mean(), y - rows.mean()])
            for x, y in ((u, v), (columns, rows))
        )
        fit = np.linalg.lstsq(centred, error, rcond=None)[0]
        rest = error - centred @ fit
        kept = np.abs(rest) < 2.5 * np.std(rest) + 1e-9
        depth = depth - own @ np.linalg.lstsq(centred[kept], error[kept], rcond=None)[0]
    at = eye + rays[rows, columns] * depth[:, None]
    z = at[:, 2] - surface
    noise = DEPTH_NOISE * (np.median(depth) / 0.65) ** 2
    level = np.median(z[np.abs(z - np.percentile(z, 85)) < 2.5 * noise + 1e-3])
    on_top = np.abs(z - level) < 3.0 * noise + 1e-3
    if on_top.sum() < FEWEST // 2 or level < LOWEST:
        return None
    colour = np.median(frame.colour[rows[on_top], columns[on_top]], axis=0) / 255.0
    last = np.array(frame.depth.shape) - 1
    border = bool(rows.min() == 0 or columns.min() == 0 or rows.max() == last[0])
    return Cluster(
        at[on_top, :2], float(level), surface, colour,
        float(np.median(depth) / frame.focal_length), border or bool(columns.max() == last[1]),
    )  # fmt: skip


def fit_rectangle(points: np.ndarray) -> Rectangle:
    """Return the rectangle of the smallest area that is evenly filled by points.

    A few points at each end do not count; its size is corrected for them.

    Args:
        points: The points, x and y [m].  # (n, 2)
    """
    points = _fewer(points)
    angles = np.radians(np.arange(0.0, 90.0, 3.0))
    best = min((_extent(points, angle) for angle in angles), key=_area)
    for step in (1.0, 0.25):
        angles = best[0] + np.radians(np.arange(-3.0 * step, 3.01 * step, step))
        best = min((_extent(points, angle) for angle in angles), key=_area)
    angle, low, high = best
    c, s = np.cos(angle), np.sin(angle)
    within = 1.0 - 2.0 * _outliers(len(points)) / len(points)
    middle, size = (low + high) / 2.0, (high - low) / within
    centre = np.array([c * middle[0] - s * middle[1], s * middle[0] + c * middle[1]])
    if size[0] < size[1]:
        size, angle = size[::-1], angle + np.pi / 2.0
    return Rectangle(centre, float(angle), (float(size[0]), float(size[1])))


def fit_circle(points: np.ndarray) -> Circle:
    """Return the circle that is evenly filled by points.

    Its centre is between the extremes along 18 directions, of which a few points do not count; its
    diameter is corrected for them.

    Args:
        points: The points, x and y [m].  # (n, 2)
    """
    points = _fewer(points)
    low, high = _bounds(points @ _DIRECTIONS.T)
    centre = np.linalg.lstsq(_DIRECTIONS, (low + high) / 2.0, rcond=None)[0]
    # Of a disc, a part q of the area is beyond cos(a) of the radius with a^3 = 1.5 pi q.
    within = np.cos(np.cbrt(1.5 * np.pi * _outliers(len(points)) / len(points)))
    return Circle(centre, float(np.median(high - low) / within))


def refine_rectangle(points: np.ndarray, start: Rectangle) -> Rectangle:
    """Move and turn a rectangle of known size so that the fewest points are outside it.

    Args:
        points: The points, x and y [m].  # (n, 2)
        start: The rectangle, with the known size.
    """
    points = _fewer(points)
    half = np.array(start.size) / 2.0

    def outside(at: np.ndarray) -> float:
        c, s = np.cos(at[2]), np.sin(at[2])
        local = np.abs((points - at[:2]) @ np.array([[c, -s], [s, c]])) - half
        return float(np.clip(local.max(axis=1), 0.0, REACH).sum())

    x, y, yaw = _minimum(outside, [*start.centre, start.yaw], (2e-3, 2e-3, 0.05))
    return Rectangle(np.array([x, y]), yaw, start.size)


def refine_circle(points: np.ndarray, start: Circle) -> Circle:
    """Move a circle of known diameter so that the fewest points are outside it.

    Args:
        points: The points, x and y [m].  # (n, 2)
        start: The circle, with the known diameter.
    """
    points = _fewer(points)

    def outside(at: np.ndarray) -> float:
        away = np.hypot(*(points - at).T) - start.diameter / 2.0
        return float(np.clip(away, 0.0, REACH).sum())

    return Circle(np.array(_minimum(outside, [*start.centre], (2e-3, 2e-3))), start.diameter)


def _minimum(cost, start, steps) -> list[float]:  # type: ignore[no-untyped-def]
    """Return where a function has its minimum near a start (Nelder-Mead)."""
    from scipy.optimize import minimize

    simplex = np.array(start) + np.vstack([np.zeros(len(start)), np.diag(steps)])
    options = {"initial_simplex": simplex, "maxiter": 80, "xatol": 1e-5, "fatol": 1e-6}
    return [float(x) for x in minimize(cost, start, method="Nelder-Mead", options=options).x]


def _fewer(points: np.ndarray) -> np.ndarray:
    """Return at most `MOST_POINTS` of the points, evenly spread over their order."""
    return points[:: 1 + len(points) // MOST_POINTS]


def _outliers(number: int) -> int:
    """Return how many of a number of points do not count at each end."""
    return min(max(3, number // 200), (number - 1) // 2)


def _bounds(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounds of the columns of an array, but for outliers."""
    few = _outliers(len(values))
    ordered = np.partition(values, [few, len(values) - 1 - few], axis=0)
    return ordered[few], ordered[-1 - few]


def _extent(points: np.ndarray, angle: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Return an angle, and the bounds of points along axes turned by it."""
    c, s = np.cos(angle), np.sin(angle)
    return float(angle), *_bounds(points @ np.array([[c, -s], [s, c]]))


def _area(extent: tuple[float, np.ndarray, np.ndarray]) -> float:
    return float(np.prod(extent[2] - extent[1]))
