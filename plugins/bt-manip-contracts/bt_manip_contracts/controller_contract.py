"""Contract of controllers."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from bt_manip.arm import Arm
from bt_manip.cell import Cell
from bt_manip.control import ComputedTorque, Controller, Hold
from bt_manip.robots import Robot, panda

MAX_STEADY_ERROR = 0.02  # [rad]: friction deflects a compliant controller
MAX_DRIFT = 1e-3  # [rad] from 0.75 s to 1 s at rest
MAX_LAG = 0.1  # [rad] tracking error while moving
MAX_TORQUE_STEP = 0.3  # relative to the effort limits, after a switch at rest
MAX_CHATTER = 0.005  # mean change of a torque from step to step, relative to the effort limits


@dataclass(frozen=True)
class ControllerCase:
    """A controller, to check on a Panda."""

    name: str
    factory: Callable[..., Any]

    def stand(self, factory: Callable[..., Any] | None = None) -> tuple[Cell, Robot, Controller]:
        """Return an empty cell with a controlled robot."""
        robot = Robot(panda())
        control = (factory or self.factory)(robot)
        robot.attach(control)
        cell = Cell()
        cell.add(robot)
        return cell, robot, control


def never_gives_nan(case: ControllerCase) -> None:
    """Check that it returns one finite effort per joint at random states and references."""
    cell, robot, control = case.stand()
    limits, rng = robot.limits, np.random.default_rng(0)
    lower, upper = limits.sampling_bounds()
    control.reference = Hold(robot.q)
    for _ in range(50):
        q, q_ref = rng.uniform(lower, upper), rng.uniform(lower, upper)
        v, v_ref = rng.uniform(-limits.velocity, limits.velocity, (2, limits.velocity.size))
        a_ref = rng.uniform(-limits.acceleration, limits.acceleration)
        tau = np.asarray(control.compute(q, v, q_ref, v_ref, a_ref))
        assert tau.shape == limits.effort.shape, (
            f"'{case.name}' gives {tau.shape}, expected {limits.effort.shape}"
        )
        assert np.isfinite(tau).all(), f"'{case.name}' gives {tau} at q = {q}"


def _efforts(cell: Cell, robot: Robot) -> np.ndarray:
    """Return the efforts that a controller commands, or that MuJoCo computes from its commands."""
    data, motors = cell.data, robot.ctrl_adr
    computed = cell.model.actuator_biastype[motors] != mujoco.mjtBias.mjBIAS_NONE
    return np.where(computed, data.actuator_force[motors], data.ctrl[motors])


def stays_inside_the_effort_limits(case: ControllerCase) -> None:
    """Check that no effort exceeds its limit after a large step of the reference."""
    cell, robot, control = case.stand()
    limits = robot.limits
    far = np.where(robot.q > 0.0, np.maximum(limits.lower, -2.0), np.minimum(limits.upper, 2.0))
    control.reference = Hold(far)
    for _ in range(200):
        cell.step()
        commanded = np.abs(_efforts(cell, robot))
        assert np.isfinite(commanded).all(), f"'{case.name}' commands {commanded}"
        assert (commanded <= limits.effort * (1 + 1e-9)).all(), (
            f"'{case.name}' commands {commanded} N m, the limits are {limits.effort}"
        )


def is_stable_at_rest(case: ControllerCase) -> None:
    """Check that it neither drifts nor oscillates at a constant reference."""
    cell, robot, control = case.stand()
    home = robot.q
    control.reference = Hold(home)
    cell.step(750)
    settled = robot.q
    cell.step(250)
    sag, creep = np.abs(robot.q - home).max(), np.abs(robot.q - settled).max()
    assert sag < MAX_STEADY_ERROR, f"'{case.name}' is {sag:.4f} rad off after a second at rest"
    assert creep < MAX_DRIFT, f"'{case.name}' still moves by {creep:.5f} rad in 0.25 s"


def returns_from_a_push(case: ControllerCase) -> None:
    """Check that it returns to its reference after a disturbance, without lasting oscillation."""
    cell, robot, control = case.stand()
    home = robot.q
    control.reference = Hold(home)
    cell.data.qvel[robot.dof_adr] = 0.2
    cell.step(1500)
    off, speed = np.abs(robot.q - home).max(), np.abs(robot.v).max()
    assert off < MAX_STEADY_ERROR, f"'{case.name}' is {off:.4f} rad off 1.5 s after a push"
    assert speed < 0.02, f"'{case.name}' still moves at {speed:.3f} rad/s 1.5 s after a push"


def follows_a_motion(case: ControllerCase) -> None:
    """Check that it tracks a motion and reaches its target."""
    cell, robot, control = case.stand()
    control.reference = arm = Arm(robot)
    target = np.clip(robot.q + 0.3, robot.limits.lower + 0.1, robot.limits.upper - 0.1)
    arm.move_to_configuration(target, speed=0.5)
    worst = 0.0
    while arm.moving:
        cell.step()
        worst = max(worst, float(np.abs(robot.q - arm.q).max()))
    cell.step(750)
    assert worst < MAX_LAG, f"'{case.name}' lags {worst:.3f} rad behind"
    assert np.abs(robot.q - target).max() < MAX_STEADY_ERROR, f"'{case.name}' does not arrive"


def does_not_chatter(case: ControllerCase) -> None:
    """Check that its torques do not alternate from step to step, at rest and in a motion."""
    cell, robot, control = case.stand()
    control.reference = arm = Arm(robot)
    cell.step(500)
    target = np.clip(robot.q + 0.3, robot.limits.lower + 0.1, robot.limits.upper - 0.1)
    for state in ("at rest", "in a motion"):
        if state == "in a motion":
            arm.move_to_configuration(target, speed=0.5)
        torques = []
        for _ in range(250):
            cell.step()
            torques.append(_efforts(cell, robot))
        changes = np.abs(np.diff(torques, axis=0)).mean(axis=0) / robot.limits.effort
        assert changes.max() <= MAX_CHATTER, (
            f"'{case.name}' chatters {state}: a torque changes by {changes.max():.1%} of its limit "
            f"in a control step, on average; {MAX_CHATTER:.1%} are allowed"
        )


def takes_over_smoothly(case: ControllerCase) -> None:
    """Check that it takes over from another controller at rest without a large torque step."""
    before_cell, before_robot, before = case.stand(ComputedTorque)
    before_cell.step(500)
    cell, robot, control = case.stand()
    robot.set_configuration(before_robot.q)
    cell.data.qvel[robot.dof_adr] = before_robot.v
    control.reference = Hold(before_robot.q)
    cell.step()
    jump = np.abs(control.tau - before.tau) / robot.limits.effort
    assert jump.max() < MAX_TORQUE_STEP, (
        f"'{case.name}' takes over with a torque step of {jump.max():.0%} of an effort limit"
    )
    cell.step(200)
    moved = float(np.abs(robot.q - before_robot.q).max())
    assert moved < MAX_STEADY_ERROR, f"'{case.name}' moves by {moved:.4f} rad when it takes over"


def goes_on_from_its_state(case: ControllerCase) -> None:
    """Check that another instance continues from its state, plain data, bit for bit."""
    cell, robot, control = case.stand()
    control.reference = Hold(robot.q + 0.05)
    cell.step(50)
    physics, state = cell.snapshot()["integration"], json.dumps(control.get_state())
    cell.step(100)
    ended = cell.state_bytes()
    other_cell, other_robot, other = case.stand()
    other.reference = Hold(robot.description.home + np.full(robot.q.shape, 0.05))
    other_cell.restore({**other_cell.snapshot(), "integration": physics})
    other.set_state(json.loads(state))
    other_cell.step(100)
    assert other_cell.state_bytes() == ended, f"'{case.name}' continues differently from its state"


CONTROLLER_CONTRACT: tuple[Callable[[ControllerCase], None], ...] = (
    never_gives_nan,
    stays_inside_the_effort_limits,
    is_stable_at_rest,
    returns_from_a_push,
    follows_a_motion,
    does_not_chatter,
    takes_over_smoothly,
    goes_on_from_its_state,
)
"""Checks of the contract; each raises `AssertionError` if it fails."""
