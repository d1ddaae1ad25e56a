"""Jogging: joint sliders, tool handle, gripper, and saved configurations."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from bt_manip import spatial
from bt_manip.exceptions import BtManipError, MotionError
from bt_manip.planning import PlanningProblem, PlanningResult
from bt_manip.runner import CommandedRobot, Run, Station

from .panel import HANDLE_SIZE, Panel, message_html

JOG_SPEED = 0.25
"""Speed of jogging, as a fraction of the limits."""

GRIP_FORCE = 50.0
"""Largest force of the button Close [N], the default of CloseGripper."""

SLIDER_STEP = 1e-3
"""Step of the joint sliders [rad] or [m]."""

EDITING = 1.0
"""Wall time after a change during which a slider does not follow its joint [s]."""

Save = Callable[[str, Sequence[float]], str]
"""Saves a configuration under a name; returns a message."""


class JogPanel(Panel):
    """Moves the arms while no tree runs, and always shows their joint positions.

    Callbacks of the inputs only store requests. Between two ticks, the thread of the cell executes
    the last request of each input.

    Attributes:
        moved: Whether an arm or gripper has been jogged since the last run or reset.
    """

    def __init__(self, page: Any, save: Save) -> None:
        self.moved = False
        self._page, self._save = page, save
        self._message = page.gui.add_html("")
        self._container = page.gui.add_folder("")
        self._robots: list[_RobotJog] = []
        self._station: Any = None

    def start(self, run: Run) -> None:
        """Disable the inputs, which still follow the joints."""
        self._bind(run.station, active=False)

    def begin_idle(self, station: Station) -> None:
        """Enable jogging."""
        self._bind(station, active=True)
        self.moved = False

    def idle_tick(self) -> None:
        """Start the requested motions."""
        for robot in self._robots:
            for key in list(robot.requests):
                try:
                    self._tell(robot.requests.pop(key)() or "")
                    self.moved |= key != "save"
                except (BtManipError, TypeError, ValueError) as error:  # also if not numbers
                    self._tell(str(error), error=True)

    def draw(self) -> None:
        """Update sliders and handles to the arms."""
        with self._page.server.atomic():
            for robot in self._robots:
                robot.follow(present=self._page.shown_time is None)

    # Internal

    def _bind(self, station: Station, *, active: bool) -> None:
        """Show the inputs of the station's robots; enable or disable jogging."""
        if station is not self._station:
            self._station = station
            for old in self._robots:
                old.remove()
            with self._container:
                self._robots = [
                    _RobotJog(self._page, robot, self._save) for robot in station.robots.values()
                ]
        self._tell("" if active else "A tree is running.")
        for robot in self._robots:
            robot.set_active(active)

    def _tell(self, message: str, *, error: bool = False) -> None:
        self._message.content = message_html(message, error=error)


class _RobotJog:
    """The inputs of one robot.

    Attributes:
        requests: Requests since the last tick, by input; a call may return a message.
    """

    def __init__(self, page: Any, robot: CommandedRobot, save: Save) -> None:
        self.requests: dict[Any, Callable[[], str | None]] = {}
        self._robot, self._arm, self._save = robot, robot.arm, save
        self._edited = np.full(self._arm.model.nq, -np.inf)  # wall time of the last change [s]
        self._dragging = self._active = False
        gui, limits = page.gui, self._arm.model.limits
        self._lower = np.maximum(limits.lower, -2.0 * np.pi)
        self._upper = np.minimum(limits.upper, 2.0 * np.pi)
        self._folder = gui.add_folder(robot.name)
        with self._folder:
            self._sliders = [
                gui.add_slider(f"{name} [{unit}]", low, high, SLIDER_STEP, low)
                for name, unit, low, high in zip(
                    robot.robot.description.arm_joints, self._arm.model.units,
                    self._lower.tolist(), self._upper.tolist(), strict=True,
                )
            ]  # fmt: skip
            self._others = []
            if robot.gripper is not None:
                gripper = gui.add_button_group("Gripper", ("Open", "Close"))
                gripper.on_click(self._gripper_pressed)
                self._others.append(gripper)
            self._name = gui.add_text("Save as", "", hint="Name of the present configuration")
            button = gui.add_button("Save configuration")
            button.on_click(self._save_pressed)
            self._others += [self._name, button]
        for i, slider in enumerate(self._sliders):
            slider.on_update(partial(self._slider_moved, i))
        self._handle = page.server.scene.add_transform_controls(
            f"/jog/{robot.name}", HANDLE_SIZE, depth_test=False
        )
        self._handle.on_update(self._handle_moved)

    def remove(self) -> None:
        """Remove the inputs from the page."""
        self._folder.remove()
        self._handle.remove()

    def set_active(self, active: bool) -> None:
        """Enable or disable jogging."""
        self.requests.clear()
        self._dragging = False
        self._edited[:] = -np.inf
        for slider in self._sliders:
            slider.disabled = not active
        self._active = active
        for one in (self._handle, *self._others):
            one.visible = active

    def follow(self, *, present: bool) -> None:
        """Show the present configuration, except in inputs that are being edited.

        The tool has a handle where the scene shows the present.
        """
        if self._handle.visible != (self._active and present):
            self._handle.visible = self._active and present
        idle = time.monotonic() - self._edited > EDITING
        if self._arm.busy:
            idle &= np.isneginf(self._edited)
        self._edited[idle] = -np.inf
        q = np.clip(self._robot.robot.q, self._lower, self._upper)
        for i in np.flatnonzero(idle & np.isfinite(q)).tolist():
            slider = self._sliders[i]
            if abs(q[i] - slider.value) > 0.6 * SLIDER_STEP:
                slider.value = round(float(q[i]), 3)
        if self._handle.visible and not self._dragging and not self._arm.busy:
            T_wt = self._arm.model.pose(self._arm.q)
            position, wxyz = T_wt.translation, spatial.quat_wxyz(T_wt)
            if np.abs(self._handle.position - position).max() > 1e-4 or (
                np.abs(self._handle.wxyz - wxyz).max() > 1e-3
            ):
                self._handle.position, self._handle.wxyz = position, wxyz

    # The thread of the cell

    def _move_joint(self, i: int, value: float) -> None:
        q = self._arm.target
        q[i] = value
        self._move(q)

    def _move_tool(self, position: Any, quat_wxyz: Any) -> None:
        T_wt = spatial.pose(position, quat_wxyz)
        ik, q = self._arm.ik, self._arm.target
        found = ik.follow(T_wt, q)
        if not found.solved:
            found = ik.nearest(T_wt, q)
        if not found.solved:
            raise MotionError(f"the pose is unreachable: {found.reason}", reason="unreachable")
        self._move(found.q)

    def _move(self, q: np.ndarray) -> None:
        self._arm.move_to_configuration(q, JOG_SPEED, planner=_NoDetour())

    def _grip(self, command: str) -> None:
        gripper = self._robot.robot.needed_gripper
        if command == "Open":
            gripper.open()
            if self._arm.payload is not None:
                self._arm.payload = None
        else:
            gripper.close(min(GRIP_FORCE, gripper.max_force))

    # Callbacks

    def _slider_moved(self, i: int, event: Any) -> None:
        self._edited[i] = time.monotonic()
        self.requests["joint", i] = partial(self._move_joint, i, event.value)

    async def _handle_moved(self, event: Any) -> None:
        self._dragging = event.phase != "end"
        if event.phase == "update":
            pose = event.target.position.copy(), event.target.wxyz.copy()
            self.requests["tool"] = partial(self._move_tool, *pose)

    def _gripper_pressed(self, event: Any) -> None:
        self.requests["gripper"] = partial(self._grip, event.value)

    def _save_pressed(self, _: Any) -> None:
        name = self._name.value
        self.requests["save"] = lambda: self._save(name, self._arm.q_ref.tolist())


class _NoDetour:
    """A planner that finds no paths: jogging takes the straight joint-space segment or fails."""

    def plan(self, problem: PlanningProblem) -> PlanningResult:
        """Return no path."""
        return PlanningResult(np.empty((0, len(problem.start))), 0, "jogging takes no detours")
