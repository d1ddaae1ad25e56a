"""External forces are detected within milliseconds, and motions alone cause no detection."""

import json
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.arm import Arm, ExternalForceGuard
from bt_manip.arm.external_force_guard import (
    CHECK_INTERVAL,
    IMPULSE_THRESHOLD,
    INITIAL_MARGIN,
    external_load,
    torque_thresholds,
)
from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld
from bt_manip.control import ComputedTorque
from bt_manip.exceptions import MotionError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda, read_description
from tests.measuring.disturbances import contacts
from tests.robot_fixtures import Box
from tests.support.small_arm import write_small_arm
from tests.trajectories.pendulum import pendulum

from .watch import arm_of

THERE = np.array([0.6, -0.3, 0.3, -2.0, 0.2, 1.8, 0.4])


class Bench:
    """The Panda under control in an otherwise empty cell."""

    def __init__(self) -> None:
        robot = Robot(panda(), gripper=TwoFingerGripper)
        self.control = control = ComputedTorque(robot)
        robot.attach(control)
        self.cell = Cell()
        self.cell.add(robot, spatial.pose((0.0, 0.0, 1.0)), free=False)
        model = robot.make_model()
        world, guard = CollisionWorld(robot, model), ExternalForceGuard(robot, model)
        self.arm = control.reference = Arm(robot, model=model, world=world, guard=guard)
        self.hand = self.cell.body_id("panda/hand")
        self.rest = self.cell.snapshot(), self.arm.get_state()

    def reset(self) -> "Bench":
        self.cell.restore(self.rest[0])
        self.arm.set_state(self.rest[1])
        self.control.reset()
        self.arm.robot.mj_data.xfrc_applied[:] = 0.0
        self.arm.robot.mj_data.qfrc_applied[:] = 0.0
        return self

    def until_detected(self, steps: int) -> int | None:
        """Step until the arm reports a fault; return after how many steps."""
        for step in range(1, steps + 1):
            self.cell.step()
            if self.arm.fault:
                return step
        return None


@pytest.fixture(scope="module")
def built() -> Bench:
    return Bench()


@pytest.fixture
def bench(built) -> Bench:
    return built.reset()


@pytest.mark.parametrize(
    ("force", "lasting", "named"), [(50.0, 20, " at joint "), (1000.0, 1, "an impulse of")]
)
def test_a_push_or_an_impact_in_any_direction_is_detected_within_20_milliseconds(
    bench, rng, force, lasting, named
):
    for _ in range(4):
        bench.reset()
        bench.arm.move_to_configuration(THERE)
        assert bench.until_detected(int(rng.integers(20, 400))) is None
        direction = rng.normal(size=3)
        push = force * direction / np.linalg.norm(direction)
        bench.cell.data.xfrc_applied[bench.hand][:3] = push
        detected = bench.until_detected(lasting)
        assert (detected is None) == (lasting == 1)
        bench.cell.data.xfrc_applied[bench.hand][:3] = 0.0
        assert detected or bench.until_detected(20 - lasting)
        assert bench.arm.fault.startswith("external force on the arm:")
        assert named in bench.arm.fault


def test_arm_stops_on_detection_and_the_next_motion_clears_the_fault(bench):
    bench.arm.move_to_configuration(THERE)
    bench.cell.step(150)
    bench.cell.data.xfrc_applied[bench.hand][:3] = [0.0, 60.0, 0.0]
    assert bench.until_detected(20)
    fault = bench.arm.fault
    bench.cell.data.xfrc_applied[bench.hand][:3] = [40.0, -120.0, 60.0]
    bench.cell.step(20)
    assert bench.arm.moving and bench.arm.fault == fault  # the first one is the reason
    bench.cell.data.xfrc_applied[bench.hand][:3] = 0.0
    bench.cell.step(400)
    assert not bench.arm.busy and np.abs(bench.arm.q - THERE).max() > 0.05
    bench.arm.move_to_configuration(THERE)
    assert bench.arm.fault == "" and bench.until_detected(1500) is None
    assert np.array_equal(bench.arm.q, THERE)


def test_arm_is_undisturbed_at_rest_while_no_force_acts_on_it(bench):
    arm = bench.arm
    bench.cell.step(20)
    assert arm.at_rest and arm.undisturbed
    for v in (0.021, -0.021, -0.019, 0.0):  # [rad/s] of a joint
        bench.cell.data.qvel[bench.cell.model.joint("panda/joint4").dofadr[0]] = v
        assert arm.at_rest == arm.undisturbed == (abs(v) < 0.02)
    bench.cell.data.xfrc_applied[bench.hand][:3] = [0.0, 40.0, 0.0]
    bench.cell.step(500)
    assert arm.at_rest and not arm.undisturbed
    bench.cell.data.xfrc_applied[bench.hand][:3] = 0.0
    bench.cell.step(500)
    assert arm.undisturbed
    arm.move_to_configuration(THERE)
    bench.cell.step(100)
    assert not arm.at_rest and not arm.undisturbed


def test_free_motions_cause_no_detection(bench, rng):
    limits = bench.arm.model.limits
    moved = 0
    while moved < 4:
        try:
            bench.arm.move_to_configuration(rng.uniform(limits.lower, limits.upper))
        except MotionError:  # some are in collision with the floor or the arm itself
            continue
        moved += 1
        assert bench.until_detected(int(rng.integers(200, 900))) is None, bench.arm.fault


def test_sudden_deceleration_of_a_stretched_arm_causes_no_detection(bench):
    arm = bench.arm
    arm.move_to_configuration(np.array([-0.4, 0.9, 0.0, -1.0, 0.0, 1.8, 0.4]))
    assert bench.until_detected(2500) is None
    for wait in range(4):  # at which step between two checks the acceleration changes
        bench.cell.step(2 * wait)
        for sign in (0.25, -0.25):  # so short that it decelerates right after accelerating
            arm.move_to_configuration(arm.q + sign * np.array([1.0, 0.0, 0.62, 0.0, 0.0, 0.0, 1.2]))
            assert bench.until_detected(600) is None, arm.fault
            assert not arm.moving


def test_contacts_are_detected_anywhere_on_the_arm_and_from_any_side():
    detected = contacts(4)
    assert detected.in_time == 4 and detected.false == 0


def test_line_with_intended_contact_continues(bench):
    tool = bench.arm.model.pose(bench.arm.q)
    below = tool * spatial.pose((0.0, 0.0, 0.06))
    bench.cell.add(Box((0.2, 0.2, 0.04)), below, name="block")
    goal = tool * spatial.pose((0.0, 0.0, 0.0325))  # 2 mm inside
    try:
        with pytest.raises(MotionError, match="blocked .* touch 'block'"):
            bench.arm.move_linear(goal, speed=0.1)
        bench.arm.move_linear(goal, speed=0.1, contact=True)
        assert bench.until_detected(2500) is None
        assert bench.cell.contacts.touching("panda", "block")
    finally:
        bench.cell.remove("block")


def test_restored_guard_detects_at_the_same_step(bench):
    bench.arm.move_to_configuration(THERE)
    bench.cell.step(103)
    bench.cell.data.xfrc_applied[bench.hand][:3] = [0.0, 50.0, 0.0]
    bench.cell.step(6)
    states = bench.cell.snapshot(), json.loads(json.dumps(bench.arm.get_state()))
    first = bench.until_detected(30)
    bench.cell.restore(states[0])
    bench.arm.set_state(states[1])
    assert bench.until_detected(30) == first
    unguarded = Arm(bench.arm.robot, model=bench.arm.model)
    unguarded.set_state(states[1])
    assert unguarded.get_state() == {**states[1], "guard": None}


def test_the_load_of_an_arm_that_accelerates_fast_is_exact_up_to_dry_friction(bench, rng):
    data, arm = bench.cell.data, bench.arm
    dofs = [bench.cell.model.joint(f"panda/joint{i}").dofadr[0] for i in range(1, 8)]
    for _ in range(4):
        data.qvel[dofs], torque = rng.uniform(-3.0, 3.0, 7), rng.uniform(-20.0, 20.0, 7)
        data.qfrc_applied[dofs] = torque
        bench.cell.step(1)
        error = np.abs(external_load(arm.robot, arm.model).values - torque)
        assert (error <= arm.model.friction + 0.1).all() and np.abs(arm.robot.a).max() > 100.0
        bench.reset()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_external_torque_that_an_arm_measures_is_a_contact_at_its_second_check_in_a_row(side):
    model, still, torque = pendulum(), np.zeros(1), np.zeros(1)
    model.friction[:] = 0.05
    guard = ExternalForceGuard(SimpleNamespace(read_tau_external=lambda: torque), model)
    limit, added = guard.thresholds[0], 0.0
    for present in (0.03, 0.3, 0.0):  # at the start of the next motion
        for share, detected in ((1.1, 0), (0.9, 0), (1.1, 0), (1.1, 1), (np.nan, 0), (1.1, 1)):
            torque[:] = side * (share * (limit + added))
            found = guard.check(model, still, still, 1e-3)
            assert (found is not None) == detected
        assert (found.load.values, found.load.thresholds) == (torque, limit + added)
        torque[:] = side * present
        guard.begin(model, still, still)
        added = 1.5 * max(present - 0.05, 0.0)  # half more than what friction leaves open


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("impulse", "before", "now", "lag", "left"),
    [  # multiples of the threshold: of the change, of the motors', and what nothing explains
        (1.5, 0.0, 0.0, 0.0, 1.5),
        (0.9, 0.0, 0.0, 0.0, None),
        (1.5, 1.0, 0.0, 0.0, None),
        (1.5, 0.0, 1.0, 0.0, None),
        (2.5, 0.5, 1.0, 0.0, 1.5),
        (1.5, -1.0, -1.0, 0.0, 1.5),
        (1.5, 0.0, 0.0, 1.0, None),
        (1.5, 0.0, 0.0, -1.0, 1.5),
        (3.0, 0.0, 1.0, 0.5, 1.5),
    ],
)
def test_an_impulse_is_what_neither_motors_nor_lag_explain(impulse, before, now, lag, left, side):
    model, dt, inertia, still = pendulum(), 1e-3, 2.0, np.zeros(1)  # 2 kg on 1 m, no gravity
    threshold = side * IMPULSE_THRESHOLD * torque_thresholds(model)
    a_ref = -lag * threshold / (0.5 * dt * inertia)  # the arm lags it by half a step
    tau = before * threshold / (CHECK_INTERVAL * dt)
    robot = SimpleNamespace(
        read_tau_external=None, read_q=lambda: still, read_v=lambda: still, a=tau / inertia,
        read_tau=lambda: tau, read_a=lambda: robot.a,
    )  # fmt: skip
    guard = ExternalForceGuard(robot, model)
    guard.begin(model, still, still)
    after = now * threshold / (CHECK_INTERVAL * dt) + inertia * a_ref
    v = impulse * threshold / inertia
    robot.read_v, robot.read_tau, robot.a = lambda: v, lambda: after, after / inertia
    found = guard.check(model, still, a_ref, dt)
    assert (found is None) == (left is None)
    if left is not None:
        assert found.load.impact and found.load.values == pytest.approx(left * threshold)


def test_thresholds_follow_from_effort_limits_and_of_weak_arms_from_the_force_of_handling(
    bench, tmp_path
):
    weak = arm_of(read_description(write_small_arm(tmp_path, effort=2.5, friction=0.3)))
    small, panda = weak.model, bench.arm.model
    assert small.levers[0] == pytest.approx(0.645)
    for model in (small, panda):  # 3 % of the limits, 1.2 N at the tool, and 2.2 times the friction
        expected = np.maximum(0.03 * model.limits.effort, 1.2 * model.levers) + 2.2 * model.friction
        assert torque_thresholds(model) == pytest.approx(expected)
    assert torque_thresholds(small)[0] > 0.03 * 2.5 + 2.2 * 0.3


@pytest.mark.parametrize("force", [(0.0, 0.0, -15.0), (12.0, 9.0, 0.0)])  # [N]
def test_a_force_at_the_start_is_tolerated_with_its_joint_torques_and_a_margin(bench, force):
    cell, arm = bench.cell, bench.arm
    cell.data.xfrc_applied[bench.hand, :3] = force
    cell.step(800)
    model, data = cell.model, cell.data
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, jacobian, None, data.xipos[bench.hand], bench.hand)
    dofs = [model.joint(f"panda/joint{i}").dofadr[0] for i in range(1, 8)]
    torques = np.abs(jacobian[:, dofs].T @ force)
    assert torques.max() > 3.0
    arm.guard.begin(arm.model, arm.v, arm.a)
    tolerated = np.array(arm.guard.get_state()["tolerated"]) - arm.guard.thresholds
    slack = INITIAL_MARGIN * (arm.model.friction + 0.1)
    assert np.abs(tolerated - INITIAL_MARGIN * torques).max() < slack.max()
    assert (tolerated <= INITIAL_MARGIN * torques + 0.1).all()
