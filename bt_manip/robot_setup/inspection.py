"""Facts about a described robot: its reach over a table, its payload, a picture."""

from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell, FrameRenderer
from bt_manip.registry import Parts
from bt_manip.robots import Robot, RobotDescription, RobotModel, compile_alone

from .reach import DownwardReach

# Of the table, seen from where the scene places the robot [m].
_X, _Y = np.arange(-0.6, 0.81, 0.1), np.arange(0.35, -0.36, -0.1)
_HEIGHT = 0.03  # [m] of the tool over the table, where it grips a small object
_GRAVITY = 9.81  # [m/s2]
_SIZE = (960, 720)  # [pixels] of a picture


class ReachMap(NamedTuple):
    """Where the tool reaches a table from above.

    Attributes:
        reached: Whether each position is, with y falling along the rows.  # (8, 15)
        configurations: One for each position reached.  # (n, nq)
    """

    reached: np.ndarray
    configurations: np.ndarray

    @property
    def share(self) -> float:
        """Share of the table that is reached."""
        return float(self.reached.mean())

    def lines(self) -> list[str]:
        """Return the map as text, the front of the robot to the right."""
        rows = ["".join("#" if cell else "." for cell in row) for row in self.reached]
        title = f"reach: {100 * self.share:.0f} % of the table from above, in squares of 0.1 m"
        return [title, *(f"  {row}" for row in rows)]


def make_robot(description: RobotDescription, parts: Parts) -> Robot:
    """Return a described robot with its gripper, compiled alone.

    Args:
        description: The description.
        parts: The registered parts, among them the kind of its gripper.

    Raises:
        BtManipError: If its kind of gripper is not registered, or it does not match its model.
    """
    gripper = description.gripper
    make = parts.grippers.maker(gripper.kind, "close", "held_root") if gripper else None
    robot = Robot(description, gripper=make)
    compile_alone(robot)
    return robot


def reach_map(robot: Robot, model: RobotModel) -> ReachMap:
    """Return where the tool of a robot, compiled alone, reaches the plane on which it stands."""
    downward, q = DownwardReach(robot, model), model.home
    reached, found = np.zeros((len(_Y), len(_X)), dtype=bool), []
    for i, y in enumerate(_Y):
        for j, x in enumerate(_X):
            one = downward.solve(np.array([x, y, _HEIGHT]), q)
            if one is not None:
                reached[i, j], q = True, one
                found.append(one)
    return ReachMap(reached, np.array(found).reshape(-1, model.nq))


def payload(model: RobotModel, configurations: np.ndarray) -> float:
    """Return the largest mass at the tool that the arm holds at rest in all configurations [kg].

    Args:
        model: The arm.
        configurations: Configurations [rad].  # (n, nq)
    """
    most, zero = np.inf, np.zeros(model.nq)
    for q in configurations:
        tau = model.rnea(q, zero, zero)
        pin.computeJointJacobians(model.model, model.data, q)
        pin.updateFramePlacements(model.model, model.data)
        per_kg = _GRAVITY * model.jacobian(q)[2]
        room = model.limits.effort - np.sign(per_kg) * tau
        loaded = np.abs(per_kg) > 1e-9
        most = min([most, *(room[loaded] / np.abs(per_kg[loaded]))])
    return float(max(most, 0.0))


def picture(robot: Robot) -> np.ndarray:
    """Return an image of a robot at home.

    Args:
        robot: The robot, which is not part of a cell yet.

    Raises:
        NoOpenGLError: If no OpenGL backend works.
    """  # (height, width, 3)
    cell = Cell()
    cell.add(robot)
    model, data = cell.model, cell.data
    mujoco.mj_forward(model, data)
    own = model.body_rootid[model.site_bodyid[robot.tool_site_id]]
    points = data.geom_xpos[model.body_rootid[model.geom_bodyid] == own]
    low, high = points.min(axis=0), points.max(axis=0)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = 0.5 * (low + high)
    camera.distance = 2.2 * float(np.linalg.norm(high - low))
    camera.azimuth, camera.elevation = 145.0, -20.0
    renderer = FrameRenderer(model, *_SIZE)
    try:
        renderer.update_scene(data, camera)
        return np.array(renderer.render())
    finally:
        renderer.close()


def summary(robot: Robot) -> list[str]:
    """Return joints with limits, tool, gripper, payload and reach of a robot, as lines of text.

    Args:
        robot: The robot, compiled alone.
    """
    description, model = robot.description, robot.make_model()
    limits = model.limits
    lines = [f"{description.name}: {description.model}", "joints:"]
    lines.append(f"  {'':24} {'from':>8} {'to':>8} {'speed':>8} {'effort':>8}")
    columns = (limits.lower, limits.upper, limits.velocity, limits.effort)
    for i, joint in enumerate(description.arm_joints):
        numbers = " ".join(f"{column[i]:8.3g}" for column in columns)
        lines.append(f"  {joint:24} {numbers}")
    x, y, z = description.T_ft.translation
    lines.append(f"tool: at {x:.3f} {y:.3f} {z:.3f} m in '{description.tool_frame}'")
    gripper = robot.gripper
    force = (
        f"{gripper.kind}, up to {gripper.max_force:g} N; {gripper.status}" if gripper else "none"
    )
    lines.append(f"gripper: {force}")
    reached = reach_map(robot, model)
    carried = payload(model, reached.configurations)
    return [*lines, *reached.lines(), f"payload: {carried:.2g} kg wherever it reaches the table"]
