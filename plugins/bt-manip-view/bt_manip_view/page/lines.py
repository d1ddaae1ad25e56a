"""Lines in the scene: line segments, and outlines of checked grasps."""

from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.grasping import CheckedGrasps
from bt_manip.robots import GraspCandidate

THICKNESS = 4.0
"""Thickness of lines [pixels]."""

NO_LINES = np.empty((0, 2, 3))

NO_POSE = pin.SE3.Identity()

GRASPS = {
    "chosen": ((47, 158, 68), 8.0),
    "clear": ((240, 140, 0), 3.0),
    "blocked": ((224, 49, 49), 3.0),
}
"""Colour and thickness [pixels] of the chosen grasp, and of others with and without clearance."""

FINGER, STEM = 0.03, 0.06
"""Lengths of the lines of a grasp along the approach direction [m]."""

SAME_POSE = 1e-4
"""Motion of an object below which its grasps are not redrawn [m] and [rad]."""


class Lines:
    """Line segments of one colour in the scene.

    Args:
        scene: Viser's scene.
        name: Name of the node.
        colour: Red, green and blue, from 0 to 255.
        thickness: Line width [pixels].
    """

    def __init__(
        self, scene: Any, name: str, colour: tuple[int, ...], thickness: float = THICKNESS
    ) -> None:
        self._scene, self._name = scene, name
        self._colour, self._thickness = colour, thickness
        self.handle: Any = None

    def show(self, segments: np.ndarray) -> None:
        """Replace the drawn segments; none removes the node.

        Args:
            segments: Ends of the segments [m].  # (n, 2, 3)
        """
        if not len(segments):
            if self.handle is not None:
                self.handle.remove()
                self.handle = None
        elif self.handle is not None:
            self.handle.points = segments
        else:
            self.handle = self._scene.add_line_segments(
                self._name, segments, self._colour,
                thickness=self._thickness, thickness_units="screen",
            )  # fmt: skip


class GraspLines:
    """Draws grasps as gripper outlines: fingers at the gripped width and the approach direction.

    Grasps move with their object.
    """

    def __init__(self, scene: Any, robot: str) -> None:
        self._lines = {
            kind: Lines(scene, f"/grasps of {robot}/{kind}", colour, thickness)
            for kind, (colour, thickness) in GRASPS.items()
        }
        self._drawn: CheckedGrasps | None = None
        self._T_wo = NO_POSE

    def show(self, checked: CheckedGrasps | None, T_wo: pin.SE3 = NO_POSE) -> None:
        """Draw checked grasps at the pose of their object in the world, or none."""
        if checked is self._drawn and (
            checked is None or self._T_wo.actInv(T_wo).isIdentity(SAME_POSE)
        ):
            return
        self._drawn, self._T_wo = checked, T_wo
        found: dict[str, list[np.ndarray]] = {kind: [] for kind in GRASPS}
        if checked is not None:
            for grasp, clear in checked.grasps:
                if grasp is not checked.chosen:
                    kind = "clear" if clear else "blocked"
                    found[kind].append(_outline(grasp, checked.closing, T_wo))
            if checked.chosen is not None:
                found["chosen"].append(_outline(checked.chosen, checked.closing, T_wo))
        for kind, lines in self._lines.items():
            lines.show(np.concatenate([NO_LINES, *found[kind]]))


def _outline(grasp: GraspCandidate, closing: np.ndarray | None, T_wo: pin.SE3) -> np.ndarray:
    """Return the lines of a grasp in the world [m]."""  # (n, 2, 3)
    z, side = np.array([0.0, 0.0, 1.0]), np.zeros(3)
    if closing is not None:
        side = 0.5 * grasp.width * closing
    back = -FINGER * z
    corners = [(side, side + back), (-side, back - side), (side + back, back - side)]
    corners.append((back, back - STEM * z))
    T_wt = T_wo * grasp.T_ot
    return np.array(corners) @ T_wt.rotation.T + T_wt.translation
