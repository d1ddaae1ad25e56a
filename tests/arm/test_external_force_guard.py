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
from bt_manip.exceptions import MotionError
from bt_manip.robots import read_description
from tests.measuring.collisions import one_arm
from tests.measuring.disturbances import contacts
from tests.robot_fixtures import Box
from tests.support.small_arm import write_small_arm
from tests.trajectories.pendulum import pendulum

from .watch import arm_of

THERE = np.array([0.6, -0.3, 0.3, -2.0, 0.2, 1.8, 0.4])


@pytest.fixture(scope="module")
def built(parts):
    station = one_arm("computed_torque", parts)
    return station, station.get_state()


@pytest.fixture
def force(station) -> np.ndarray:
    """Give the force on the hand [N], to be set."""
    return station.cell.data.xfrc_applied[station.cell.body_id("panda/hand")][:3]


def until_detected(station, steps: int) -> int | None:
    """Step until the arm reports a fault; return after how many steps."""
    for step in range(1, steps + 1):
        station.cell.step()
        if station.arm.fault:
            return step
    return None


@pytest.mark.parametrize(
    ("size", "lasting", "named"), [(50.0, 20, " at joint "), (1000.0, 1, "an impulse of")]
)
def test_a_push_or_an_impact_in_any_direction_is_detected_within_20_milliseconds(
    station, rng, force, size, lasting, named
):
    start = station.get_state()
    for _ in range(4):
        station.set_state(start)
        station.arm.move_to_configuration(THERE)
        assert until_detected(station, int(rng.integers(20, 400))) is None
        direction = rng.normal(size=3)
        force[:] = size * direction / np.linalg.norm(direction)
        detected = until_detected(station, lasting)
        assert (detected is None) == (lasting == 1)
        force[:] = 0.0
        assert detected or until_detected(station, 20 - lasting)
        assert station.arm.fault.startswith("external force on the arm:")
        assert named in station.arm.fault


def test_arm_stops_on_detection_and_the_next_motion_clears_the_fault(station, force):
    station.arm.move_to_configuration(THERE)
    station.cell.step(150)
    force[:] = [0.0, 60.0, 0.0]
    assert until_detected(station, 20)
    fault = station.arm.fault
    force[:] = [40.0, -120.0, 60.0]
    station.cell.step(20)
    assert station.arm.moving and station.arm.fault == fault  # the first one is the reason
    force[:] = 0.0
    station.cell.step(400)
    assert not station.arm.busy and np.abs(station.arm.q - THERE).max() > 0.05
    station.arm.move_to_configuration(THERE)
    assert station.arm.fault == "" and until_detected(station, 1500) is None
    assert np.array_equal(station.arm.q, THERE)


def test_arm_is_undisturbed_at_rest_while_no_force_acts_on_it(station, force):
    arm = station.arm
    station.cell.step(20)
    assert arm.at_rest and arm.undisturbed
    for v in (0.021, -0.021, -0.019, 0.0):  # [rad/s] of a joint
        station.cell.data.qvel[station.cell.model.joint("panda/joint4").dofadr[0]] = v
        assert arm.at_rest == arm.undisturbed == (abs(v) < 0.02)
    force[:] = [0.0, 40.0, 0.0]
    station.cell.step(500)
    assert arm.at_rest and not arm.undisturbed
    force[:] = 0.0
    station.cell.step(500)
    assert arm.undisturbed
    arm.move_to_configuration(THERE)
    station.cell.step(100)
    assert not arm.at_rest and not arm.undisturbed


def test_free_motions_cause_no_detection(station, rng):
    limits = station.arm.model.limits
    moved = 0
    while moved < 4:
        try:
            station.arm.move_to_configuration(rng.uniform(limits.lower, limits.upper))
        except MotionError:  # some are in collision with the floor or the arm itself
            continue
        moved += 1
        assert until_detected(station, int(rng.integers(200, 900))) is None, station.arm.fault


def test_sudden_deceleration_of_a_stretched_arm_causes_no_detection(station):
    arm = station.arm
    arm.move_to_configuration(np.array([-0.4, 0.9, 0.0, -1.0, 0.0, 1.8, 0.4]))
    assert until_detected(station, 2500) is None
    for wait in range(4):  # at which step between two checks the acceleration changes
        station.cell.step(2 * wait)
        for sign in (0.25, -0.25):  # so short that it decelerates right after accelerating
            arm.move_to_configuration(arm.q + sign * np.array([1.0, 0.0, 0.62, 0.0, 0.0, 0.0, 1.2]))
            assert until_detected(station, 600) is None, arm.fault
            assert not arm.moving


def test_contacts_are_detected_anywhere_on_the_arm_and_from_any_side():
    detected = contacts(4)
    assert detected.in_time == 4 and detected.false == 0


def test_line_with_intended_contact_continues(station):
    tool = station.arm.model.pose(station.arm.q)
    below = tool * spatial.pose((0.0, 0.0, 0.06))
    station.cell.add(Box((0.2, 0.2, 0.04)), below, name="block")
    goal = tool * spatial.pose((0.0, 0.0, 0.0325))  # 2 mm inside
    try:
        with pytest.raises(MotionError, match="blocked .* touch 'block'"):
            station.arm.move_linear(goal, speed=0.1)
        station.arm.move_linear(goal, speed=0.1, contact=True)
        assert until_detected(station, 2500) is None
        assert station.cell.contacts.touching("panda", "block")
    finally:
        station.cell.remove("block")


def test_restored_guard_detects_at_the_same_step(station, force):
    station.arm.move_to_configuration(THERE)
    station.cell.step(103)
    force[:] = [0.0, 50.0, 0.0]
    station.cell.step(6)
    states = station.cell.snapshot(), json.loads(json.dumps(station.arm.get_state()))
    first = until_detected(station, 30)
    station.cell.restore(states[0])
    station.arm.set_state(states[1])
    assert until_detected(station, 30) == first
    unguarded = Arm(station.arm.robot, model=station.arm.model)
    unguarded.set_state(states[1])
    assert unguarded.get_state() == {**states[1], "guard": None}


def test_the_load_of_an_arm_that_accelerates_fast_is_exact_up_to_dry_friction(station, rng):
    data, arm, start = station.cell.data, station.arm, station.get_state()
    dofs = [station.cell.model.joint(f"panda/joint{i}").dofadr[0] for i in range(1, 8)]
    for _ in range(4):
        data.qvel[dofs], torque = rng.uniform(-3.0, 3.0, 7), rng.uniform(-20.0, 20.0, 7)
        data.qfrc_applied[dofs] = torque
        station.cell.step(1)
        error = np.abs(external_load(arm.robot, arm.model).values - torque)
        assert (error <= arm.model.friction + 0.1).all() and np.abs(arm.robot.a).max() > 100.0
        station.set_state(start)


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
    station, tmp_path
):
    weak = arm_of(read_description(write_small_arm(tmp_path, effort=2.5, friction=0.3)))
    small, panda = weak.model, station.arm.model
    assert small.levers[0] == pytest.approx(0.645)
    for model in (small, panda):  # 3 % of the limits, 1.2 N at the tool, and 2.2 times the friction
        expected = np.maximum(0.03 * model.limits.effort, 1.2 * model.levers) + 2.2 * model.friction
        assert torque_thresholds(model) == pytest.approx(expected)
    assert torque_thresholds(small)[0] > 0.03 * 2.5 + 2.2 * 0.3


@pytest.mark.parametrize("given", [(0.0, 0.0, -15.0), (12.0, 9.0, 0.0)])  # [N]
def test_a_force_at_the_start_is_tolerated_with_its_joint_torques_and_a_margin(
    station, force, given
):
    cell, arm, hand = station.cell, station.arm, station.cell.body_id("panda/hand")
    force[:] = given
    cell.step(800)
    model, data = cell.model, cell.data
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, jacobian, None, data.xipos[hand], hand)
    dofs = [model.joint(f"panda/joint{i}").dofadr[0] for i in range(1, 8)]
    torques = np.abs(jacobian[:, dofs].T @ given)
    assert torques.max() > 3.0
    arm.guard.begin(arm.model, arm.v, arm.a)
    tolerated = np.array(arm.guard.get_state()["tolerated"]) - arm.guard.thresholds
    slack = INITIAL_MARGIN * (arm.model.friction + 0.1)
    assert np.abs(tolerated - INITIAL_MARGIN * torques).max() < slack.max()
    assert (tolerated <= INITIAL_MARGIN * torques + 0.1).all()
