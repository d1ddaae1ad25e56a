"""What one asks of a path of the tool, step by step: where to, and by which way."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.checks import check_number, check_pose, check_vector, invalid
from bt_manip.exceptions import MotionError

from .tool_path_segments import Arc, Line, Segment

_SHORT = 1e-6  # [m] between points that are no circle's
_FLAT = 1e-6  # sine of the angle at the via point below which three points are on a line


@dataclass(frozen=True, eq=False)
class LineTo:
    """A straight line to a pose, turning evenly on the way.

    Attributes:
        pose: Pose T_wt of the tool at its end.
    """

    pose: pin.SE3

    def __post_init__(self) -> None:
        """Refuse what is no pose."""
        check_pose(self.pose)

    def after(self, start: pin.SE3) -> tuple[Segment, pin.SE3]:
        """Give the way from a pose, and its end."""
        return Line(start, self.pose), self.pose


@dataclass(frozen=True, eq=False)
class ArcTo:
    """The arc of a circle to a pose, through a point, turning evenly on the way.

    Attributes:
        via: A point of the arc in the world [m].  # (3,)
        pose: Pose T_wt of the tool at its end.
    """

    via: Sequence[float] | np.ndarray
    pose: pin.SE3

    def __post_init__(self) -> None:
        """Refuse what is no point or no pose."""
        check_vector(self.via, "via point of an arc", "m")
        check_pose(self.pose)

    def after(self, start: pin.SE3) -> tuple[Segment, pin.SE3]:
        """Give the way from a pose, and its end.

        Raises:
            MotionError: When start, point and end are no points of one circle.
        """
        a, b, c = start.translation, np.array(self.via, dtype=float), self.pose.translation
        ab, ac, bc = b - a, c - a, c - b
        normal = np.cross(ab, ac)
        sides = [float(np.linalg.norm(side)) for side in (ab, ac, bc)]
        if min(sides) < _SHORT or np.linalg.norm(normal) < _FLAT * sides[0] * sides[1]:
            raise MotionError(
                "an arc goes through three points that are apart and not on a line, got "
                + ", ".join(f"({x:.4f}, {y:.4f}, {z:.4f})" for x, y, z in (a, b, c)),
                reason="target",
            )
        # The circumcentre, by the sides' squares; see any text on the geometry of triangles.
        towards = sides[1] ** 2 * np.cross(normal, ab) + sides[0] ** 2 * np.cross(ac, normal)
        centre = a + towards / (2.0 * float(normal.dot(normal)))
        axis = normal / np.linalg.norm(normal)
        spoke, last = a - centre, c - centre
        angle = float(np.arctan2(axis.dot(np.cross(spoke, last)), spoke.dot(last))) % (2.0 * np.pi)
        turn = pin.log3(start.rotation.T @ self.pose.rotation)
        return Arc(start, centre, angle * axis, turn), self.pose


@dataclass(frozen=True, eq=False)
class TurnAbout:
    """A turn of the tool about an axis in the world, as if it were fixed to it.

    Attributes:
        point: A point of the axis [m].  # (3,)
        axis: Its direction, of any length.  # (3,)
        angle: By how much, right-handed about the direction [rad].
    """

    point: Sequence[float] | np.ndarray
    axis: Sequence[float] | np.ndarray
    angle: float

    def __post_init__(self) -> None:
        """Refuse what is no axis or no angle."""
        check_vector(self.point, "point of the axis of a turn", "m")
        if np.linalg.norm(check_vector(self.axis, "axis of a turn")) < 1e-9:
            raise invalid(f"axis of a turn must not be zero, got {self.axis}")
        check_number(self.angle, "angle of a turn", "rad")

    def after(self, start: pin.SE3) -> tuple[Segment, pin.SE3]:
        """Give the way from a pose, and its end."""
        axis = np.array(self.axis, dtype=float)
        axis /= np.linalg.norm(axis)
        point = np.array(self.point, dtype=float)
        centre = point + axis.dot(start.translation - point) * axis
        sweep = float(self.angle) * axis
        arc = Arc(start, centre, sweep, start.rotation.T @ sweep)
        return arc, arc.pose(arc.travel) if arc.travel else start


Step = LineTo | ArcTo | TurnAbout


def check_steps(steps: Any) -> list[Step]:
    """Give the steps of a path as a list.

    Raises:
        MotionError: When one is none.
    """
    if not isinstance(steps, Iterable):
        raise MotionError(
            f"a path is a list of LineTo, ArcTo and TurnAbout, got {type(steps).__name__}",
            reason="target",
        )
    found = list(steps)
    for step in found:
        if not isinstance(step, Step):
            raise MotionError(
                f"a step of a path is a LineTo, ArcTo or TurnAbout, got {type(step).__name__}",
                reason="target",
            )
    return found
