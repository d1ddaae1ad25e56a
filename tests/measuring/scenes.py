"""Planning scenes: a wall between two poses, and random obstacles."""

import contextlib
from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip import spatial
from bt_manip.arm import Arm, ExternalForceGuard
from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld
from bt_manip.control import ComputedTorque
from bt_manip.exceptions import MotionError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.kinematics import InverseKinematics
from bt_manip.robots import Robot, RobotDescription, panda

TOP = ((0.7, 1.2, 0.1), (0.55, 0.0, -0.05))
WALL = ((0.5, 0.04, 0.4), (0.5, 0.0, 0.2))

SCALES = {"ur5e": 1.0, "xarm7": 0.8, "iiwa14": 1.0, "fr3": 1.0}
"""Scale of the wall scene for other arms, by their reach."""


class Fixed(composer.Entity):
    """A box, cylinder or sphere that stands fixed."""

    def _build(self, kind: str, size: Sequence[float], name: str = "obstacle") -> None:
        self._root = mjcf.RootElement(model=name)
        self._root.worldbody.add("geom", name="geom", type=kind, size=list(size))

    mjcf_model = property(lambda self: self._root)


class Planned(NamedTuple):
    """An arm under control among obstacles, its base in the origin of the world."""

    cell: Cell
    robot: Robot
    control: ComputedTorque
    gripper: TwoFingerGripper
    arm: Arm
    open: np.ndarray  # positions of all joints with the gripper open
    name: str  # of the robot in the cell


YAWS = (0.0, 0.5 * np.pi, -0.5 * np.pi)  # [rad] of the hand; not every arm reaches with each


def build(
    obstacles: Sequence[tuple[str, Sequence[float], pin.SE3]],
    description: RobotDescription | None = None,
) -> Planned:
    """Put a robot, by default the Panda, among obstacles: kind, size of MuJoCo and pose of each."""
    robot = Robot(description or panda(), gripper=TwoFingerGripper)
    control = ComputedTorque(robot)
    gripper = robot.gripper
    robot.attach(control)
    arena = composer.Arena()
    arena.mjcf_model.option.cone = "elliptic"
    cell = Cell(arena)
    with cell.editing():
        name = cell.add(robot, free=False, overlap=np.inf)  # home may be in collision
        for i, (kind, size, pose) in enumerate(obstacles):
            cell.add(Fixed(kind, size), pose, name=f"obstacle_{i}", free=False, overlap=np.inf)
    model = robot.make_model()
    arm = Arm(
        robot,
        model=model,
        world=CollisionWorld(robot, model),
        guard=ExternalForceGuard(robot, model),
    )
    control.reference = arm
    return Planned(cell, robot, control, gripper, arm, cell.data.qpos.copy(), name)


def wall(
    description: RobotDescription | None = None, scale: float = 1.0
) -> tuple[Planned, pin.SE3, pin.SE3]:
    """Return a scene with a wall over a table, and a tool pose on either side of it.

    All lengths are scaled, for robots with another reach than the Panda, the default.
    """
    boxes = [
        ("box", 0.5 * scale * np.array(size), spatial.pose(scale * np.array(at)))
        for size, at in (TOP, WALL)
    ]
    planned = build(boxes, description)
    left, right = (_downwards(planned, scale * np.array((0.5, y, 0.12))) for y in (0.25, -0.25))
    return planned, left, right


def _downwards(planned: Planned, position: np.ndarray) -> pin.SE3:
    """Return the first collision-free tool pose that points down at a position."""
    turned = [spatial.pointing_down(position, yaw) for yaw in YAWS]
    for pose in turned:
        with contextlib.suppress(MotionError):
            free_start(planned, pose)
            return pose
    return turned[0]


def free_start(planned: Planned, T_wt: pin.SE3) -> np.ndarray:
    """Return a collision-free configuration near home with the tool at a pose."""
    arm = planned.arm
    assert arm.world is not None
    for found in arm.ik.solutions(T_wt, arm.model.home, margin=0.05):
        if not arm.world.collisions(found.q):
            return found.q
    raise MotionError("no free configuration was found", reason="unreachable")


def random_scene(
    seed: int, description: RobotDescription | None = None
) -> tuple[Planned, np.ndarray, np.ndarray]:
    """Draw five to ten obstacles and two free configurations with the tool before the robot."""
    rng = np.random.default_rng(seed)
    obstacles = [("box", (1.0, 1.0, 0.05), spatial.pose((0.0, 0.0, -0.07)))]
    for _ in range(int(rng.integers(5, 11))):
        kind = str(rng.choice(["box", "cylinder", "sphere"]))
        sizes = {"box": 3, "cylinder": 2, "sphere": 1}[kind]
        size = rng.uniform(0.03, 0.14, sizes)
        angle, radius = rng.uniform(-2.0, 2.0), rng.uniform(0.4, 0.8)
        at = (radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.05, 0.8))
        yaw = rng.uniform(-np.pi, np.pi)
        turn = (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2))
        obstacles.append((kind, size, spatial.pose(at, turn)))
    planned = build(obstacles, description)
    ends = []
    ik = planned.arm.ik
    while len(ends) < 2:
        q = _random_configuration(rng, ik)
        apart = not ends or np.abs(q - ends[0]).max() > 1.0
        if apart and _clear(planned, q):
            ends.append(q)
    return planned, ends[0], ends[1]


def _clear(planned: Planned, q: np.ndarray) -> bool:
    """Tell whether a configuration has the clearance from all obstacles that planners use."""
    world = planned.arm.world
    own = planned.name
    return not world.collisions(q) and all(
        near.first.split("/")[0] == near.second.split("/")[0] == own
        for near in world.collisions(q, 8e-3)
    )


def _random_configuration(rng: np.random.Generator, ik: InverseKinematics) -> np.ndarray:
    """Draw a configuration with the tool before the robot and not under it."""
    limits = ik.model.limits
    lower, upper = np.maximum(limits.lower + 0.1, -np.pi), np.minimum(limits.upper - 0.1, np.pi)
    while True:
        q = rng.uniform(lower, upper)
        x, y, z = ik.model.pose(q).translation
        if x > 0.2 and abs(y) < 0.7 and 0.05 < z < 0.9:
            return q


def put(planned: Planned, q: np.ndarray) -> None:
    """Put the arm at rest at a configuration, the gripper held open."""
    data = planned.cell.data
    data.qpos[:] = planned.open
    data.qvel[:] = data.qacc[:] = 0.0
    planned.robot.set_configuration(q)
    mujoco.mj_forward(planned.cell.model, data)
    planned.control.reset()
    planned.gripper.open()
    planned.arm.reset(q)
