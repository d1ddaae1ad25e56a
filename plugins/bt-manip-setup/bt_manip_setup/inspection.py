"""Facts about a described robot: reach over a table, payload, an image."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell, FrameRenderer, escaped_name, literal_name
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.robots import (
    Gripper,
    GripperError,
    Robot,
    RobotDescription,
    RobotModel,
    compile_alone,
)
from bt_manip.spatial import quat_wxyz
from bt_manip_contracts import RobotCase
from bt_manip_setup.finger_travel import find_fingers

from .reach import GRASP_HEIGHT, DownwardReach

# Grid on the table, in the frame where the scene places the robot [m].
_X, _Y = np.arange(-0.6, 0.81, 0.1), np.arange(0.35, -0.36, -0.1)
_TILT = 0.35  # [rad] largest angle of the tool's z axis to the approach direction
_DEPTH = 0.02  # [m] largest distance of the tool from the measured position
_GRAVITY = 9.81  # [m/s2]
_SIZE = (960, 720)  # [pixels] of an image


class ReachMap(NamedTuple):
    """Reach of the tool over a table, from above.

    Attributes:
        reached: Whether each position is reached; y decreases with the row.  # (8, 15)
        payload: Largest mass at the tool that the arm holds at rest at all reached positions [kg].
        gripped: Largest mass that the gripper holds with its default force and a friction
            coefficient of 1 [kg]; inf without a gripper.
        below_tool: Height of the tool above the lowest point of the open gripper [m].
    """

    reached: np.ndarray
    payload: float
    gripped: float
    below_tool: float

    def lines(self) -> list[str]:
        """Return the map, with the front of the robot to the right, and the payload as text."""
        share = 100 * float(self.reached.mean())
        rows = ["".join("#" if cell else "." for cell in row) for row in self.reached]
        lines = [
            f"reach: {share:.0f} % of the table from above (#), in squares of 0.1 m; x to the right"
        ]
        lines += [f"  {row}" for row in rows]
        if self.reached.any():
            grip = "" if np.isinf(self.gripped) else f"; the grip holds {self.gripped:.2g} kg"
            lines.append(f"payload: {self.payload:.2g} kg wherever it reaches the table{grip}")
        return lines


def make_robot(description: RobotDescription, parts: Parts) -> Robot:
    """Return a described robot with its gripper, compiled alone.

    Args:
        description: The description.
        parts: The registered parts, among them the kind of its gripper.

    Raises:
        BtManipError: If its gripper kind is not registered, or it does not match its model.
    """
    return compiled(robot_case(description, parts))


def robot_case(description: RobotDescription, parts: Parts) -> RobotCase:
    """Return a described robot with its kind of gripper, as its contract takes it.

    Raises:
        BtManipError: If its gripper kind is not registered.
    """
    if description.gripper is None:
        return RobotCase(description)
    make = parts.grippers.maker(description.gripper.kind, "close", "held_root")
    return RobotCase(description, make)


def compiled(case: RobotCase) -> Robot:
    """Return the robot of a case, compiled alone.

    Raises:
        BtManipError: If its gripper does not match its model.
    """
    robot = Robot(case.description, gripper=case.gripper)
    compile_alone(robot)
    return robot


def reach_map(robot: Robot, model: RobotModel) -> ReachMap:
    """Return the reach of a robot, compiled alone, over the plane on which it stands."""
    downward, q, below = DownwardReach(robot, model), model.home, 0.0
    reached, found = np.zeros((len(_Y), len(_X)), dtype=bool), []
    for i, y in enumerate(_Y):
        for j, x in enumerate(_X):
            one = downward.solve(np.array([x, y, GRASP_HEIGHT]), q)
            if one is not None:
                q = one
                found.append(one)
                below = downward.lowest.below_tool(one)
                reached[i, j] = below < GRASP_HEIGHT
    return ReachMap(reached, _payload(model, found), _gripped(robot.gripper), below)


def _gripped(gripper: Gripper | None) -> float:
    """Return the largest mass that a gripper holds with its default force [kg]."""
    if gripper is None:
        return float("inf")
    force, masses = gripper.default_force(), np.geomspace(1e-3, 1e3, 241)  # in steps of 6 %

    def holds(mass: float) -> bool:
        try:
            return gripper.required_friction(_GRAVITY * mass, force) <= 1.0
        except GripperError:
            return False

    return float(max((mass for mass in masses if holds(mass)), default=0.0))


def _payload(model: RobotModel, configurations: Sequence[np.ndarray]) -> float:
    """Return the largest mass at the tool that the arm holds at rest in all configurations [kg]."""
    up = np.array([0.0, 0.0, 1.0])
    return min((model.static_force(q, up) for q in configurations), default=np.inf) / _GRAVITY


def picture(robot: Robot) -> np.ndarray:
    """Return an image of a robot at home.

    Args:
        robot: The robot, not yet in a cell.

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
    with FrameRenderer(model, *_SIZE) as renderer:
        renderer.update_scene(data, camera)
        return np.array(renderer.render())


def stands_on(description: RobotDescription) -> str:
    """Describe the support of the base of a robot."""
    x, y, z = description.T_rb.translation
    at = f"with its origin at {x:.3g} {y:.3g} {z:.3g} m there"
    if description.pedestal is None:
        return f"on the plane where a scene places the robot, {at}"
    size = " x ".join(f"{length:g}" for length in description.pedestal)
    return f"on a block of {size} m, on the plane where a scene places the robot, {at}"


def summary(robot: Robot) -> list[str]:
    """Return lines of text about joints, limits, tool, gripper, payload and reach of a robot.

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
    lines.append(f"base: {stands_on(description)}")
    lines.append(f"tool: at {x:.3f} {y:.3f} {z:.3f} m in '{description.tool_frame}'")
    one = robot.gripper
    force = f"{one.kind}, up to {one.max_force:g} N; {one.status}" if one else "none"
    return [*lines, f"gripper: {force}", *reach_map(robot, model).lines()]


def tool_findings(description: RobotDescription) -> Iterator[str]:
    """Yield differences of the tool frame from the fingers measured on the model."""
    if description.gripper is None:
        return
    try:
        where, robot = description.where, Robot(description)
        found = find_fingers(robot.alone, [escaped_name(name) for name in description.arm_joints])
        compile_alone(robot)
    except BtManipError:  # other kinds of grippers
        return
    T_bt, body = found.T_bt, literal_name(found.body.rpartition("/")[2])
    data, ids = robot.mj_data, robot.mj_model
    at = next(b for b in range(ids.nbody) if ids.body(b).name.endswith(found.body))
    T_wb = pin.SE3(data.xmat[at].reshape(3, 3), data.xpos[at])
    T_bs = T_wb.inverse() * robot.tool_pose
    angle = float(np.arccos(np.clip(T_bs.rotation[:, 2] @ T_bt.rotation[:, 2], -1.0, 1.0)))
    p = ", ".join(f"{x:.4g}" for x in T_bt.translation + 0.0)
    q = ", ".join(f"{x:.4g}" for x in quat_wxyz(T_bt))
    remedy = f'frame = "{body}", position = [{p}], quat_wxyz = [{q}] fit the fingers'
    if angle > _TILT:
        yield (
            f"{where}: key 'tool': its z axis, the direction of approach, is "
            f"{np.degrees(angle):.0f} degrees from that of the fingers; {remedy}"
        )
    offset = T_bt.actInv(T_bs.translation)
    if float(np.abs(offset).max()) > _DEPTH:
        yield (
            f"{where}: key 'tool': it is {1e3 * float(np.linalg.norm(offset)):.0f} mm from the "
            f"middle of the finger pads; {remedy}"
        )
