"""Motions disturbed by forces or unknown obstacles, and undisturbed ones."""

from typing import NamedTuple

import mujoco
import numpy as np

from bt_manip import spatial
from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotDescription
from tests.measuring.scenes import Fixed, Planned, put, random_scene

FORCE = 50.0  # [N] of a push
DURATION = 50  # control steps that a push lasts
CONTACT_FORCE = 20.0  # [N] of a contact from which it has to be detected
DETECTION_LIMIT = 20  # control steps within which a disturbance has to be detected
CASES_PER_SCENE = 10
_LONGEST = 60  # control steps after which a disturbance counts as not detected


class Detections(NamedTuple):
    """Detections of some disturbances."""

    # Control steps from when each was due, negative before; None where there was none.
    steps: list[int | None]
    false: int  # number of motions stopped before any disturbance

    @property
    def in_time(self) -> int:
        """Number of detections in time."""
        return sum(step is not None and step <= DETECTION_LIMIT for step in self.steps)

    @property
    def slowest(self) -> float:
        """The slowest detection [control steps]."""
        return max(np.inf if step is None else step for step in self.steps)


def pushes(count: int, description: RobotDescription | None = None) -> Detections:
    """Push the hand in random directions at random times of motions."""
    rng = np.random.default_rng(4)
    steps: list[int | None] = []
    false = 0
    for number in range(count):
        if number % CASES_PER_SCENE == 0:
            planned, start, goal = random_scene(number // CASES_PER_SCENE, description)
        _begin(planned, start, goal, number)
        planned.cell.step(int(rng.uniform(0.05, 0.85) * planned.arm.remaining / 1e-3))
        false += bool(planned.arm.fault)
        direction = rng.normal(size=3)
        force = planned.cell.data.xfrc_applied[planned.robot.wrist_body_id]
        force[:3] = FORCE * direction / np.linalg.norm(direction)
        steps.append(_until_fault(planned, DURATION))
        force[:] = 0.0
    return Detections(steps, false)


def _until_fault(planned: Planned, most: int) -> int | None:
    for step in range(1, most + 1):
        planned.cell.step()
        if planned.arm.fault:
            return step
    return None


def contacts(count: int, description: RobotDescription | None = None) -> Detections:
    """Put an unknown obstacle on the path of any part of the arm.

    A case counts if the contact force exceeds `CONTACT_FORCE` or is detected before.
    """
    rng = np.random.default_rng(5)
    steps: list[int | None] = []
    false = drawn = 0
    while len(steps) < count:
        if drawn % CASES_PER_SCENE == 0:
            planned, start, goal = random_scene(drawn // CASES_PER_SCENE, description)
        _begin(planned, start, goal, drawn)
        drawn += 1
        planned.cell.step(int(rng.uniform(0.05, 0.5) * planned.arm.remaining / 1e-3))
        if planned.arm.fault:
            false += 1
            continue
        if _put_obstacle(planned, rng):
            found = _collide(planned)
            if found is not None:
                steps.append(found if found <= _LONGEST else None)
            planned.cell.remove("unseen")
    return Detections(steps, false)


def _put_obstacle(planned: Planned, rng: np.random.Generator) -> bool:
    """Put a box where some part of the arm will be; False where it touches something now."""
    cell, arm, robot = planned.cell, planned.arm, planned.robot
    q = arm.follower.ahead(rng.uniform(0.1, 0.9, 1) * arm.remaining)[0]
    model, data = cell.model, mujoco.MjData(cell.model)
    data.qpos[:] = cell.data.qpos
    data.qpos[robot.qpos_adr] = q
    mujoco.mj_kinematics(model, data)
    moving = np.flatnonzero(_of_arm(planned) & (model.geom_contype > 0))
    geom = int(rng.choice(moving))
    half = rng.uniform(0.02, 0.06, 3)
    turn = rng.normal(size=4)
    near = data.geom_xpos[geom] + rng.uniform(-0.05, 0.05, 3)
    pose = spatial.pose(near, turn / np.linalg.norm(turn))
    # Contact right now would be no collision of a moving arm.
    cell.add(Fixed("box", half, "unseen"), pose, name="unseen", free=False, overlap=np.inf)
    mujoco.mj_forward(cell.model, cell.data)
    if cell.contacts.pairs() or cell.data.ncon:
        cell.remove("unseen")
        return False
    return True


def _of_arm(planned: Planned) -> np.ndarray:
    """Mark the geoms that move with the arm."""
    model = planned.cell.model
    first = model.dof_bodyid[planned.robot.dof_adr[0]]
    mine = np.zeros(model.nbody, dtype=bool)
    mine[first] = True
    for body in range(first + 1, model.nbody):
        mine[body] = mine[model.body_parentid[body]]
    return mine[model.geom_bodyid]


def _collide(planned: Planned) -> int | None:
    """Return how many steps after the force exceeded its limit it was detected; None if it did not.

    No detection within `_LONGEST` steps counts as more.
    """
    cell, arm = planned.cell, planned.arm
    over = None
    for step in range(int(arm.remaining / 1e-3) + _LONGEST):
        cell.step()
        if over is None and _force(planned) > CONTACT_FORCE:
            over = step
        if arm.fault:
            return -1 if over is None else step - over
        if over is not None and step - over > _LONGEST:
            return _LONGEST + 1
    return None


def _force(planned: Planned) -> float:
    """Sum the normal forces of all contacts [N]."""
    model, data = planned.cell.model, planned.cell.data
    force, total = np.zeros(6), 0.0
    for i in range(data.ncon):
        mujoco.mj_contactForce(model, data, i, force)
        total += force[0]
    return total


def undisturbed(count: int, description: RobotDescription | None = None) -> int:
    """Make undisturbed motions; return how many were stopped."""
    stopped = 0
    for number in range(count):
        planned, start, goal = random_scene(number, description)
        if not _begin(planned, start, goal, number):
            continue
        while planned.arm.moving:
            planned.cell.step()
        stopped += bool(planned.arm.fault)
    return stopped


def _begin(planned: Planned, start: np.ndarray, goal: np.ndarray, seed: int) -> bool:
    """Start a motion to a goal or, where there is no path, to a random configuration nearby."""
    put(planned, start)
    rng = np.random.default_rng(seed)
    for target in (goal, *(start + rng.uniform(-0.5, 0.5, (20, len(start))))):
        try:
            planned.arm.move_to_configuration(target, rng=rng)
        except MotionError:
            continue
        return True
    return False
