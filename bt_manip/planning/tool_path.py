"""The tool on lines and arcs, with rounded corners between them."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import accumulate

import numpy as np
import pinocchio as pin

from bt_manip.checks import check_non_negative
from bt_manip.robots import ToolLimits
from bt_manip.trajectories import TOPP_GRIDS, KinematicLimits

from .tool_path_segments import Segment
from .tool_path_steps import Step, check_steps

GRID = 25  # intervals in the narrowest corner
FINEST_GRID = 2000  # intervals on a path
NARROWEST = 0.015  # of the way, that a corner takes in which the tool does not halt
_SAME = 1e-9  # [m] and [rad]
_PER_AXIS = 3.0**-0.5  # of a limit of a vector, so that it holds whichever way that points


class ToolPath:
    """A path of the tool that can be driven without a halt.

    Its parameter, the travel, is the way in metres, where a turn counts too. In a corner, what
    comes before slows down evenly while what comes after sets out: place and rotation have three
    continuous derivatives there, as long as what meets are lines.

    Attributes:
        length: Way along the pieces up to their corners [m].
        travel: The same with turns [m].
        straight: Whether it is a single line.
        finest: Share of the travel that its narrowest corner takes; 1 without corners.
    """

    def __init__(
        self,
        segments: Sequence[Segment],
        blend: float = 0.0,
        *,
        before: float = 0.0,
        whole: float | None = None,
        length_before: float = 0.0,
        whole_length: float | None = None,
    ) -> None:
        """Join pieces, each of which starts where the one before ends.

        Args:
            segments: At least one; corners between several are rounded.
            blend: How far from a corner it is rounded [m], where the pieces are long enough.
            before: Travel of what is driven before this path [m].
            whole: Travel of all that is driven [m]; by default of this path.
            length_before: Length of what is driven before this path [m].
            whole_length: Length of all that is driven [m]; by default of this path.
        """
        self._segments = list(segments)
        travels = [segment.travel for segment in segments]
        self._starts = [0.0, *accumulate(travels)]
        self.travel = self._starts[-1]
        self.length = sum(segment.length for segment in segments)
        self.angle = sum(segment.angle for segment in segments)
        self.straight = len(self._segments) == 1 and self._segments[0].straight
        self._cuts = [
            _cut(first, second, blend)
            for first, second in zip(segments, segments[1:], strict=False)
        ]
        self.finest = min((2.0 * cut / self.travel for cut in self._cuts), default=1.0)
        self._before, self._length_before = before, length_before
        self._whole = self.travel if whole is None else whole
        self._whole_length = self.length if whole_length is None else whole_length

    def pose(self, fraction: float) -> pin.SE3:
        """Give the pose T_wt at a fraction of the travel."""
        way = min(max(fraction, 0.0), 1.0) * self.travel
        i = min(bisect_right(self._starts, way) - 1, len(self._segments) - 1)
        since, left = way - self._starts[i], self._starts[i + 1] - way
        if i > 0 and since < self._cuts[i - 1]:
            return self._corner(i - 1, since)
        if i < len(self._cuts) and left < self._cuts[i]:
            return self._corner(i, -left)
        return self._segments[i].pose(since)

    def _corner(self, i: int, since: float) -> pin.SE3:
        """Give the pose near a corner, by the travel since it."""
        first, second, cut = self._segments[i], self._segments[i + 1], self._cuts[i]
        part = 0.5 * (1.0 + since / cut)
        corner = second.pose(0.0)
        coming = first.pose(first.travel - cut * _ramp(1.0 - part))
        going = second.pose(cut * _ramp(part))
        place = coming.translation + going.translation - corner.translation
        return pin.SE3(coming.rotation @ corner.rotation.T @ going.rotation, place)

    def carried(self, fractions: np.ndarray) -> np.ndarray:
        """Give what a path in joint space carries behind the joints, at even fractions.

        The fraction comes last. Where the path bends, place and angle of the tool come before it:
        the angle is the integral of the turning, so that its derivatives are those that have
        limits.
        """  # (n, 1) or (n, 7)
        if self.straight:
            return fractions[:, np.newaxis]
        poses = [self.pose(fraction) for fraction in fractions]
        turned = [
            pin.log3(b.rotation @ a.rotation.T) for a, b in zip(poses, poses[1:], strict=False)
        ]
        angles = np.cumsum([np.zeros(3), *turned], axis=0)
        return np.column_stack([[T.translation for T in poses], angles, fractions])

    def bounds(self, joints: KinematicLimits, tool: ToolLimits) -> KinematicLimits:
        """Append the limits of what is carried, which bound the tool's motion."""
        slope = self.travel * max(segment.length / segment.travel for segment in self._segments)
        turning = self.travel * max(segment.angle / segment.travel for segment in self._segments)

        def least(linear: float, angular: float) -> float:
            return min(linear / max(slope, _SAME), angular / max(turning, _SAME))

        bounds = joints
        for velocity, acceleration, jerk in (
            ()
            if self.straight
            else (
                *[(tool.velocity, tool.acceleration, tool.jerk)] * 3,
                *[(tool.angular_velocity, tool.angular_acceleration, tool.angular_jerk)] * 3,
            )
        ):
            bounds = bounds.with_coordinate(velocity, _PER_AXIS * acceleration, _PER_AXIS * jerk)
        return bounds.with_coordinate(
            least(tool.velocity, tool.angular_velocity),
            least(tool.acceleration, tool.angular_acceleration),
            least(tool.jerk, tool.angular_jerk),
        )

    @property
    def grids(self) -> tuple[int, ...]:
        """Intervals that it is fine enough to look at this path in when it is timed."""
        fine = int(min(GRID / self.finest, FINEST_GRID))
        return TOPP_GRIDS if fine <= TOPP_GRIDS[0] else (max(fine, TOPP_GRIDS[-1]), FINEST_GRID)

    @property
    def name(self) -> str:
        """How errors call it."""
        return "line" if self.straight and self._whole == self.travel else "path"

    def progress(self, fraction: float) -> tuple[float, str, str]:
        """Tell how much of all that is driven has been driven at a fraction of this path.

        Returns:
            The share of the travel, and texts of that and of the metres.
        """
        share = (self._before + fraction * self.travel) / self._whole
        gone = self._length_before + fraction * self.length
        metres = f"{gone:.3f} m of {self._whole_length:.3f} m"
        return share, f"{100.0 * share:.0f} % of the way", metres


def tool_paths(start: pin.SE3, steps: Sequence[Step], blend: float = 0.0) -> list[ToolPath]:
    """Lay out steps from a pose of the tool.

    Args:
        start: Where the tool is.
        steps: Where to, and by which way.
        blend: How far from a corner it is rounded [m]. At 0, and where that takes less than
            `NARROWEST` of the way, the tool halts there.

    Returns:
        Paths with a halt after each; none where nothing moves.

    Raises:
        MotionError: When a step is none, or the blend is no length.
    """
    blend = check_non_negative(blend, "blend", "m")
    segments: list[Segment] = []
    for step in check_steps(steps):
        segment, start = step.after(start)
        if segment.length >= _SAME or segment.angle >= _SAME:
            segments.append(segment)
    whole = sum(segment.travel for segment in segments)
    whole_length = sum(segment.length for segment in segments)
    paths, before, length_before = [], 0.0, 0.0
    for group in _between_halts(segments, blend, whole):
        path = ToolPath(
            group,
            blend,
            before=before,
            whole=whole,
            length_before=length_before,
            whole_length=whole_length,
        )
        paths.append(path)
        before, length_before = before + path.travel, length_before + path.length
    return paths


def _between_halts(segments: Sequence[Segment], blend: float, whole: float) -> list[list[Segment]]:
    """Part pieces at corners that are not rounded, or too narrowly for the way they are on."""
    groups: list[list[Segment]] = []
    for i, segment in enumerate(segments):
        if i > 0 and 2.0 * _cut(segments[i - 1], segment, blend) >= NARROWEST * whole:
            groups[-1].append(segment)
        else:
            groups.append([segment])
    return groups


def _cut(first: Segment, second: Segment, blend: float) -> float:
    """Give the travel on both sides of a corner that is rounded: at most half of a piece."""
    steepest = max(first.length / first.travel, second.length / second.travel, _SAME)
    return min(blend / steepest, 0.5 * first.travel, 0.5 * second.travel)


def _ramp(x: float) -> float:
    """Rise from rest at 0 to 1 with slope 2 at 1, with no curvature at either."""
    return x**4 * (5.0 - 6.0 * x + 2.0 * x * x)
