"""Contract of robots."""

import json
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bt_manip.cell import Cell
from bt_manip.control import ComputedTorque
from bt_manip.grippers import TwoFingerGripper
from bt_manip.kinematics import InverseKinematics
from bt_manip.robots import Gripper, Robot, RobotDescription
from bt_manip_contracts.model_comparison import verify

AGREEMENT = 1e-9
RANDOM_POSES = 50
REACHED = 0.95  # of random reachable poses
MAX_TOOL_SAG = 2e-3  # [rad]


@dataclass(frozen=True)
class RobotCase:
    """A robot with its kind of gripper."""

    description: RobotDescription
    gripper: Callable[[Robot], Gripper] = TwoFingerGripper
    """Factory of its gripper, if its description has one."""

    @property
    def name(self) -> str:
        """Its name."""
        return self.description.name

    def stand(self) -> tuple[Cell, Robot]:
        """Return an empty cell with the controlled robot."""
        robot = Robot(self.description, gripper=self.gripper)
        robot.attach(ComputedTorque(robot))
        cell = Cell()
        cell.add(robot)
        return cell, robot


def its_model_agrees_with_mujoco(case: RobotCase) -> None:
    """Mass matrix, bias forces and frames equal MuJoCo's at random configurations."""
    cell, robot = case.stand()
    model = robot.make_model()
    found = verify(
        cell.model, model.model, rng=np.random.default_rng(0), n=20, qpos=model.locked_qpos
    )
    assert found.worst < AGREEMENT, f"the model of '{case.name}' differs from MuJoCo's: {found}"


def it_reaches_what_it_can_reach(case: RobotCase) -> None:
    """Inverse kinematics solves poses of random configurations."""
    _, robot = case.stand()
    model = robot.make_model()
    ik, rng = InverseKinematics(model), np.random.default_rng(1)
    lower, upper = model.limits.sampling_bounds()
    found = [
        ik.solve(model.pose(rng.uniform(lower, upper)), model.home) for _ in range(RANDOM_POSES)
    ]
    reached = sum(result.solved for result in found)
    assert reached >= REACHED * RANDOM_POSES, (
        f"'{case.name}' reaches {reached} of {RANDOM_POSES} poses"
    )
    for result in found:
        assert not result.solved or model.limits.contain(result.q, 1e-9)


def it_stands_still_at_home(case: RobotCase) -> None:
    """Under control it holds its home, without unexpected contacts."""
    cell, robot = case.stand()
    home = robot.q
    cell.step(500)
    sag = float(np.abs(robot.q - home).max())
    assert sag < MAX_TOOL_SAG, f"'{case.name}' sags by {sag:.4f} rad at home"
    unexpected = cell.contact_monitor.summary().unexpected
    assert not unexpected, f"'{case.name}' touches itself at home: {unexpected}"


def its_gripper_opens_and_closes(case: RobotCase) -> None:
    """Its gripper, if any, closes without an object and opens completely."""
    cell, robot = case.stand()
    gripper = robot.gripper
    if gripper is None:
        return
    gripper.close(0.2 * gripper.max_force)
    cell.step(1500)
    if type(gripper).closed_on_nothing is Gripper.closed_on_nothing:  # it cannot tell
        closed = not (gripper.is_open or gripper.steady)
    else:
        closed = gripper.closed_on_nothing
    assert closed, f"'{case.name}' does not close: {gripper.status}"
    gripper.open()
    cell.step(1500)
    assert gripper.is_open, f"'{case.name}' does not open: {gripper.status}"


def its_gripper_continues_from_its_state(case: RobotCase) -> None:
    """From its state when open and when closing, it continues bit for bit after any command."""
    cell, robot = case.stand()
    gripper = robot.gripper
    if gripper is None:
        return
    parts = list(robot.iter_entities(exclude_self=True))  # the gripper and the controller

    def close() -> None:
        gripper.close(0.2 * gripper.max_force)

    for first, other in ((gripper.open, close), (close, gripper.open)):
        first()
        cell.step(100)
        state, kept = cell.snapshot(), [json.dumps(part.get_state()) for part in parts]
        ends = []
        for _ in range(2):
            cell.step(200)
            ends.append(cell.state_bytes())
            other()
            cell.step(300)
            cell.restore(state)
            for part, text in zip(parts, kept, strict=True):
                part.set_state(json.loads(text))
        assert ends[0] == ends[1], (
            f"the gripper of '{case.name}' does not continue from its state: what changes during a "
            "run belongs into get_state and set_state"
        )


ROBOT_CONTRACT: tuple[Callable[[RobotCase], None], ...] = (
    its_model_agrees_with_mujoco,
    it_reaches_what_it_can_reach,
    it_stands_still_at_home,
    its_gripper_opens_and_closes,
    its_gripper_continues_from_its_state,
)
"""Checks of the contract; each raises an `AssertionError`."""
