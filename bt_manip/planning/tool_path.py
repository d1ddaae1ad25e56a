"""Cartesian paths of the tool: lines and arcs, with blended corners between them."""

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.robots import (
    ToolLimits,
    check_non_negative,
    check_number,
    check_pose,
    check_vector,
    invalid,
)
from bt_manip.trajectories import TOPP_GRIDS

ARM_LENGTH = 0.3  # [m/rad] travel that a rotation counts as
MIN_CORNER = 0.015  # share of the whole travel; the tool stops in narrower corners
CORNER_INTERVALS = 25  # grid intervals in the narrowest corner
MAX_INTERVALS = 2000  # grid intervals on a path
_ZERO = 1e-9  # [m] and [rad]
_SHOWN = 5e-4  # [m] and [rad] of a motion from which a message gives them
_MIN_DISTANCE = 1e-6  # [m] between the three points of an arc
_MIN_SINE = 1e-6  # of the angle at the via point; below it the three points are collinear
_PER_AXIS = 3.0**-0.5  # share of a vector limit that each axis gets: it holds in every direction


class Segment:
    """A piece of a path along which position and rotation change at constant rates.

    Args:
        start: Pose of the tool at the start.
        position: Returns the tool's position at a fraction of the segment [m].
        length: As below.
        turn: Rotation vector in the tool frame [rad].  # (3,)
        straight: As below.

    Attributes:
        straight: Whether it is a line.
        length: Length of the tool origin's path [m].
        angle: Angle by which the tool turns [rad].
        travel: Path parameter at the end [m]: the larger of length and `ARM_LENGTH` times angle.
    """

    def __init__(
        self,
        start: pin.SE3,
        position: Callable[[float], np.ndarray],
        length: float,
        turn: np.ndarray,
        *,
        straight: bool = False,
    ) -> None:
        self._rotation, self._position, self._turn = start.rotation.copy(), position, turn
        self.straight = straight
        self.length, self.angle = length, float(np.linalg.norm(turn))
        self.travel = max(self.length, ARM_LENGTH * self.angle)

    def pose(self, travel: float) -> pin.SE3:
        """Return the pose T_wt after a travel between 0 and `self.travel` [m]."""
        s = travel / self.travel
        return pin.SE3(self._rotation @ pin.exp3(s * self._turn), self._position(s))


def _arc(start: pin.SE3, centre: np.ndarray, sweep: np.ndarray, turn: np.ndarray) -> Segment:
    """Return a circular arc: `sweep` is the rotation vector [rad] about the `centre` [m]."""
    radius = start.translation - centre
    length = float(np.linalg.norm(radius)) * float(np.linalg.norm(sweep))
    return Segment(start, lambda s: centre + pin.exp3(s * sweep) @ radius, length, turn)


@dataclass(frozen=True, eq=False)
class LineTo:
    """A straight line to a pose, with constant angular velocity.

    Attributes:
        pose: Pose T_wt of the tool at its end.
    """

    pose: pin.SE3

    def __post_init__(self) -> None:
        """Check the pose."""
        check_pose(self.pose)

    def segment(self, start: pin.SE3) -> tuple[Segment, pin.SE3]:
        """Return the segment from a pose T_wt, and the pose at its end."""
        first, offset = start.translation.copy(), self.pose.translation - start.translation
        turn = pin.log3(start.rotation.T @ self.pose.rotation)
        length = float(np.linalg.norm(offset))
        line = Segment(start, lambda s: first + s * offset, length, turn, straight=True)
        return line, self.pose


@dataclass(frozen=True, eq=False)
class ArcTo:
    """A circular arc to a pose through a point, with constant angular velocity.

    Attributes:
        via: A point of the arc in the world [m].  # (3,)
        pose: Pose T_wt of the tool at its end.
    """

    via: Sequence[float] | np.ndarray
    pose: pin.SE3

    def __post_init__(self) -> None:
        """Check the point and the pose."""
        check_vector(self.via, "via point of an arc", "m")
        check_pose(self.pose)

    def segment(self, start: pin.SE3) -> tuple[Segment, pin.SE3]:
        """Return the segment from a pose T_wt, and the pose at its end.

        Raises:
            MotionError: When the three points coincide or are collinear.
        """
        a, b, c = start.translation, np.array(self.via, dtype=float), self.pose.translation
        ab, ac, bc = b - a, c - a, c - b
        normal = np.cross(ab, ac)
        sides = [float(np.linalg.norm(side)) for side in (ab, ac, bc)]
        if min(sides) < _MIN_DISTANCE or np.linalg.norm(normal) < _MIN_SINE * sides[0] * sides[1]:
            points = ", ".join(f"({x:.4f}, {y:.4f}, {z:.4f})" for x, y, z in (a, b, c))
            raise invalid(
                f"an arc goes through three points that are apart and not on a line, got {points}"
            )
        # Circumcentre of the triangle abc.
        towards = sides[1] ** 2 * np.cross(normal, ab) + sides[0] ** 2 * np.cross(ac, normal)
        centre = a + towards / (2.0 * float(normal.dot(normal)))
        axis = normal / np.linalg.norm(normal)
        first, last = a - centre, c - centre
        angle = float(np.arctan2(axis.dot(np.cross(first, last)), first.dot(last))) % (2.0 * np.pi)
        turn = pin.log3(start.rotation.T @ self.pose.rotation)
        return _arc(start, centre, angle * axis, turn), self.pose


@dataclass(frozen=True, eq=False)
class TurnAbout:
    """A rotation of the tool about an axis fixed in the world.

    Attributes:
        point: A point of the axis [m].  # (3,)
        axis: Its direction, of any length.  # (3,)
        angle: Right-handed about the direction [rad].
    """

    point: Sequence[float] | np.ndarray
    axis: Sequence[float] | np.ndarray
    angle: float

    def __post_init__(self) -> None:
        """Check axis and angle."""
        check_vector(self.point, "point of the axis of a turn", "m")
        if np.linalg.norm(check_vector(self.axis, "axis of a turn")) < 1e-9:
            raise invalid(f"axis of a turn must not be zero, got {self.axis}")
        check_number(self.angle, "angle of a turn", "rad")

    def segment(self, start: pin.SE3) -> tuple[Segment, pin.SE3]:
        """Return the segment from a pose T_wt, and the pose at its end."""
        axis = np.array(self.axis, dtype=float)
        axis /= np.linalg.norm(axis)
        point = np.array(self.point, dtype=float)
        centre = point + axis.dot(start.translation - point) * axis
        sweep = float(self.angle) * axis
        arc = _arc(start, centre, sweep, start.rotation.T @ sweep)
        return arc, arc.pose(arc.travel) if arc.travel else start


Step = LineTo | ArcTo | TurnAbout


class ToolPath:
    """Consecutive segments that the tool passes without stopping.

    The path parameter is the travel of its segments. In a corner, the motion along the first
    segment fades out while that along the second fades in: position and rotation have three
    continuous derivatives where lines meet.

    Args:
        segments: Segments of the motion, each starting where the previous one ends.
        blend: Distance from a corner where blending starts [m]; at most half a segment.
        first: Index of the first segment of this path.
        end: Index of the first segment after it.

    Attributes:
        length: Length along the segments, corners included [m].
        angle: Sum of the angles of the segments [rad].
        travel: Sum of the travels of the segments [m].
        straight: Whether it is a single line.
        narrowest: Share of the travel that the narrowest corner takes; 1 without corners.
    """

    def __init__(self, segments: Sequence[Segment], blend: float, first: int, end: int) -> None:
        self._segments = own = segments[first:end]
        self._starts = [0.0, *accumulate(segment.travel for segment in own)]
        self.travel = self._starts[-1]
        self.length = sum(segment.length for segment in own)
        self.angle = sum(segment.angle for segment in own)
        self.straight = len(own) == 1 and own[0].straight
        self._blends = [_blend_travel(a, b, blend) for a, b in pairwise(own)]
        self.narrowest = min((2.0 * half / self.travel for half in self._blends), default=1.0)
        self._before = _totals(segments[:first])
        self._whole = _totals(segments)
        self.name = "line" if self.straight and len(segments) == 1 else "path"

    def pose(self, fraction: float) -> pin.SE3:
        """Return the pose T_wt at a fraction of the travel."""
        travel = min(max(fraction, 0.0), 1.0) * self.travel
        i = min(bisect_right(self._starts, travel) - 1, len(self._segments) - 1)
        since, left = travel - self._starts[i], self._starts[i + 1] - travel
        if i > 0 and since < self._blends[i - 1]:
            return self._corner(i - 1, since)
        if i < len(self._blends) and left < self._blends[i]:
            return self._corner(i, -left)
        return self._segments[i].pose(since)

    def _corner(self, i: int, since: float) -> pin.SE3:
        """Return the pose T_wt in a blended corner, by the signed travel from the corner [m]."""
        first, second, half = self._segments[i], self._segments[i + 1], self._blends[i]
        s = 0.5 * (1.0 + since / half)
        corner = second.pose(0.0)
        incoming = first.pose(first.travel - half * _ramp(1.0 - s))
        outgoing = second.pose(half * _ramp(s))
        position = incoming.translation + outgoing.translation - corner.translation
        return pin.SE3(incoming.rotation @ corner.rotation.T @ outgoing.rotation, position)

    def extra_columns(self, fractions: np.ndarray) -> np.ndarray:
        """Return the columns that a joint path along this path has behind the joints.

        The last column is the fraction. Where the path is not a single line, the tool's position
        and the integral of its angular velocity come first, so that they can be limited too.

        Args:
            fractions: Evenly spaced fractions of the travel.  # (n,)
        """  # (n, 1) or (n, 7)
        if self.straight:
            return fractions[:, np.newaxis]
        poses = [self.pose(fraction) for fraction in fractions]
        turns = [pin.log3(b.rotation @ a.rotation.T) for a, b in pairwise(poses)]
        angles = np.cumsum([np.zeros(3), *turns], axis=0)
        return np.column_stack([[T.translation for T in poses], angles, fractions])

    def limits(self, tool: ToolLimits) -> np.ndarray:
        """Return the limits of velocity, acceleration and jerk of `extra_columns`."""  # (3, k)
        slope = self.travel * max(segment.length / segment.travel for segment in self._segments)
        turning = self.travel * max(segment.angle / segment.travel for segment in self._segments)

        def fraction_limit(linear: float, angular: float) -> float:
            return min(linear / max(slope, _ZERO), angular / max(turning, _ZERO))

        linear = (tool.velocity, tool.acceleration, tool.jerk)
        angular = (tool.angular_velocity, tool.angular_acceleration, tool.angular_jerk)
        fraction = [*map(fraction_limit, linear, angular)]
        if self.straight:
            return np.array([fraction]).T
        per_axis = np.array([[1.0], [_PER_AXIS], [_PER_AXIS]])
        return np.column_stack([per_axis * np.array([*[linear] * 3, *[angular] * 3]).T, fraction])

    @property
    def grids(self) -> tuple[int, ...]:
        """Grid sizes for time parameterization, fine enough for the narrowest corner."""
        intervals = int(min(CORNER_INTERVALS / self.narrowest, MAX_INTERVALS))
        if intervals <= TOPP_GRIDS[0]:
            return TOPP_GRIDS
        return max(intervals, TOPP_GRIDS[-1]), MAX_INTERVALS

    def progress(self, fraction: float) -> tuple[float, str]:
        """Return the share of the whole motion done at a fraction of this path, and a text of it.

        The text has percent, metres where the tool moves, and radians where it turns.
        """
        own = np.array([self.travel, self.length, self.angle])
        done, whole = self._before + fraction * own, self._whole
        parts = [
            f"{done[i]:.3f} {unit} of {whole[i]:.3f} {unit}"
            for i, unit in ((1, "m"), (2, "rad"))
            if whole[i] >= _SHOWN
        ]
        share = float(done[0] / whole[0])
        listed = f" ({', '.join(parts)})" if parts else ""
        return share, f"{100.0 * share:.0f} %{listed}"


def tool_paths(start: pin.SE3, steps: Iterable[Step], blend: float = 0.0) -> list[ToolPath]:
    """Build the paths of the steps of one motion, with a stop after each path.

    Args:
        start: Pose T_wt of the tool at the start.
        steps: Lines, arcs and turns.
        blend: Distance from a corner where blending starts [m]. At 0, and where a corner would take
            less than `MIN_CORNER` of the motion, the tool stops in the corner.

    Returns:
        The paths; none when nothing moves.

    Raises:
        MotionError: When a step or the blend is invalid.
    """
    blend = check_non_negative(blend, "blend", "m")
    segments: list[Segment] = []
    for step in _check_steps(steps):
        segment, start = step.segment(start)
        if segment.length >= _ZERO or segment.angle >= _ZERO:
            segments.append(segment)
    corner = MIN_CORNER * sum(segment.travel for segment in segments)
    stops = [
        i
        for i, (a, b) in enumerate(pairwise(segments), 1)
        if 2.0 * _blend_travel(a, b, blend) < corner
    ]
    ends = pairwise([0, *stops, len(segments)]) if segments else ()
    return [ToolPath(segments, blend, i, j) for i, j in ends]


def _check_steps(steps: Any) -> list[Step]:
    """Return the steps as a list.

    Raises:
        MotionError: When one is not a step.
    """
    if not isinstance(steps, Iterable):
        kind = type(steps).__name__
        raise invalid(f"a path is a list of LineTo, ArcTo and TurnAbout, got {kind}")
    found = list(steps)
    for step in found:
        if not isinstance(step, Step):
            kind = type(step).__name__
            raise invalid(f"a step of a path is a LineTo, ArcTo or TurnAbout, got {kind}")
    return found


def _blend_travel(first: Segment, second: Segment, blend: float) -> float:
    """Return the travel on either side of a blended corner [m]: at most half of a segment."""
    steepest = max(first.length / first.travel, second.length / second.travel, _ZERO)
    return min(blend / steepest, 0.5 * first.travel, 0.5 * second.travel)


def _totals(segments: Sequence[Segment]) -> np.ndarray:
    """Return the sums of travels [m], lengths [m] and angles [rad]."""  # (3,)
    totals = [(segment.travel, segment.length, segment.angle) for segment in segments]
    return np.sum(totals, axis=0) if totals else np.zeros(3)


def _ramp(x: float) -> float:
    """Return a ramp from 0 to 1 with slope 0 at 0 and 2 at 1, and zero curvature at both."""
    return x**4 * (5.0 - 6.0 * x + 2.0 * x * x)
