"""Planned paths, contact forces and frames in the scene."""

from html import escape
from typing import Any

import numpy as np

from bt_manip.grasping import CheckedGrasps
from bt_manip.runner import Run, Station
from bt_manip_recording import tool_path

from .lines import NO_LINES, GraspLines, Lines
from .panel import Panel
from .plot_panel import LINE_COLOURS

FORCE_SCALE = 0.005
"""Scale of force lines [m/N]."""

FORCE_COLOUR = (224, 49, 49)


class OverlayPanel(Panel):
    """Draws planned paths of the tools, checked grasps, contact forces, and frames.

    They are computed only while some browser shows the page.
    """

    needs_run = True

    def __init__(self, page: Any) -> None:
        self._page, self._server = page, page.server
        self._checkbox = page.gui.add_checkbox(
            "Planned paths", True, hint="Draw the path of the tool during each motion"
        )
        self._with_forces = page.gui.add_checkbox(
            "Contact forces", False, hint=f"Draw the forces on objects, {FORCE_SCALE:g} m per N"
        )
        self._with_grasps = page.gui.add_checkbox(
            "Grasps", False,
            hint="Draw the grasps that were checked last: the chosen one green, others with "
            "clearance for the gripper orange, those without red",
        )  # fmt: skip
        self._with_frames = page.gui.add_checkbox(
            "Frames", False, hint="Draw the axes of all bodies: x red, y green, z blue"
        )
        self._with_frames.on_update(lambda event: page.view.show_frames(event.value))
        self._html = page.gui.add_html("")
        self._forces = Lines(self._server.scene, "/contact forces", FORCE_COLOUR)
        self._lines: dict[str, Lines] = {}  # by robot
        self._grasps: dict[str, GraspLines] = {}  # by robot
        self._drawn: dict[str, tuple[Any, str]] = {}  # trajectory and text, by robot
        self._robots: dict[str, Any] = {}

    def start(self, run: Run) -> None:
        """Draw the paths of a run."""
        self.begin_idle(run.station)

    def begin_idle(self, station: Station) -> None:
        """Draw the paths of jogging."""
        self.reset()
        self._cell, self._robots = station.cell, dict(station.robots)
        scene = self._server.scene
        for i, name in enumerate(self._robots):
            colour = tuple(bytes.fromhex(LINE_COLOURS[i % len(LINE_COLOURS)][1:]))
            self._lines[name] = Lines(scene, f"/planned path of {name}", colour)
            self._grasps[name] = GraspLines(scene, name)
        self._models = {name: robot.arm.model.copy() for name, robot in self._robots.items()}

    def reset(self) -> None:
        """Remove the lines."""
        for name in self._robots:
            self._remove(name)
            self._grasps[name].show(None)
        self._forces.show(NO_LINES)

    def draw(self) -> None:
        """Draw the paths of new motions, remove those of motions that have ended."""
        is_open = self._page.is_open and self._page.shown_time is None  # they are of the present
        shown = self._checkbox.value and is_open
        for name, robot in self._robots.items():
            trajectory = robot.arm.trajectory
            if not shown or not robot.arm.busy:
                self._remove(name)
            elif trajectory is not None and trajectory is not self._drawn.get(name, (None,))[0]:
                self._add(name, trajectory)
            self._draw_grasps(name, robot.grasp_planner.checked if is_open else None)
        texts = sorted(text for _, text in self._drawn.values())
        self._html.content = "".join(f"<div>{escape(text)}</div>" for text in texts)
        if self._robots:
            wanted = self._with_forces.value and is_open
            self._forces.show(self._force_lines() if wanted else NO_LINES)

    # Internal

    def _force_lines(self) -> np.ndarray:
        """Return lines from the contact points along the normal forces on objects [m]."""
        # (n, 2, 3)
        cell = self._cell
        points = [
            point
            for name in cell.entities
            if name not in self._robots and cell.model.body_weldid[cell.body_id(name)] != 0
            for point in cell.contacts.points(name)
        ]
        if not points:
            return NO_LINES
        starts = np.array([point.position for point in points])
        forces = np.array([point.force * point.normal for point in points])
        return np.stack([starts, starts + FORCE_SCALE * forces], axis=1)

    def _draw_grasps(self, name: str, checked: CheckedGrasps | None) -> None:
        wanted = checked if self._with_grasps.value else None
        if wanted is None or wanted.object not in self._cell.entities:
            self._grasps[name].show(None)
        else:
            self._grasps[name].show(wanted, self._cell.pose(wanted.object))

    def _add(self, name: str, trajectory: Any) -> None:
        points = tool_path(self._models[name], trajectory)
        segments = np.stack([points[:-1], points[1:]], axis=1)
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        self._drawn[name] = trajectory, f"{name}: {length:.2f} m in {trajectory.duration:.2f} s"
        self._lines[name].show(segments)

    def _remove(self, name: str) -> None:
        self._drawn.pop(name, None)
        self._lines[name].show(NO_LINES)
