"""The controllers of a robot are switched in a run, without a step in torque."""

import json

import numpy as np
import pytest
from dm_control import composer

from bt_manip.cell import Cell
from bt_manip.control import (
    ComputedTorque,
    ControlError,
    Controller,
    ControllerManager,
    GravityCompensatedPD,
    Hold,
)
from bt_manip.control.controller import TRANSFER_TIME
from bt_manip.control.exceptions import ControllerFault
from bt_manip.robots import Payload, Robot

from .conftest import Wave

LOAD = (12.0, 4.0)  # [N m] on the joints: shifts PD control by 20 and 18 mrad
LARGEST_STEP = 0.02  # of the effort limit


class Broken(Controller):
    """Returns no torques."""

    kind = "broken"

    def compute(self, q, v, q_ref, v_ref, a_ref):
        raise ValueError("no torques")


class Unclipped(GravityCompensatedPD):
    """Takes torques beyond the limits for a fault."""

    kind = "unclipped"
    saturates = False


FACTORIES = {
    "computed_torque": ComputedTorque,
    "pd": GravityCompensatedPD,
    "unclipped": Unclipped,
    "broken": Broken,
}


@pytest.fixture
def make(description):
    """Build a cell with the two links under several controllers."""

    def make_managed(default="computed_torque", load=(0.0, 0.0)):
        robot = Robot(description)
        manager = ControllerManager(robot, FACTORIES, default)
        robot.attach(manager)
        cell = Cell()
        cell.add(robot)
        cell.data.qfrc_applied[robot.dof_adr] = load
        return cell, robot, manager

    return make_managed


def torques(cell, manager, steps):
    """Step, and return the torques of each step."""  # (steps, 2)
    rows = []
    for _ in range(steps):
        cell.step()
        rows.append(manager.controller.tau.copy())
    return np.array(rows)


@pytest.mark.parametrize("moving", [False, True], ids=["at rest", "at 1 rad/s"])
def test_switching_moves_no_torque_by_more_than_the_reference_asks_for(make, moving):
    runs = []
    for switches in ({}, {400: "pd", 550: "computed_torque", 560: "unclipped"}):
        cell, robot, manager = make(load=LOAD)
        manager.reference = Wave(robot.q, 0.25 if moving else 0.0, 4.0)  # up to 1 rad/s
        rows = [np.zeros(2)]
        for i in range(700):
            if i in switches:
                manager.switch(switches[i])
            rows.extend(torques(cell, manager, 1))
        runs.append(np.diff(rows, axis=0))
    unswitched, switched = runs
    difference = np.abs(switched - unswitched)[350:] / robot.limits.effort
    assert difference.max() < LARGEST_STEP


def test_a_switch_begins_with_the_torque_of_the_previous_controller_and_ends_after_a_time(make):
    after = []
    for name in ("computed_torque", "pd"):
        cell, robot, manager = make(load=LOAD)
        manager.reference = Wave(robot.q, 0.25, 4.0)
        cell.step(500)
        manager.switch(name)
        after.append(torques(cell, manager, 1))
    np.testing.assert_allclose(*after, atol=1e-9)
    cell.step(round(TRANSFER_TIME / cell.dt) - 1)
    q, v, reference = robot.q, robot.v, manager.reference
    expected = manager.controller.compute(q, v, reference.q, reference.v, reference.a)
    cell.step()
    np.testing.assert_array_equal(manager.controller.tau, expected)


def test_a_reference_at_rest_continues_from_the_measured_configuration(make):
    cell, robot, manager = make("pd", load=LOAD)
    cell.step(2000)
    assert np.abs(manager.reference.q - robot.q).min() > 0.01
    measured = robot.q
    manager.switch("computed_torque")
    np.testing.assert_array_equal(manager.reference.q, measured)


def test_only_the_active_controller_commands_and_others_are_made_when_needed(make):
    cell, robot, manager = make()
    assert manager.active == "computed_torque"
    cell.step(10)
    first = manager.controller
    manager.switch("pd")
    assert manager.active == "pd" and type(manager.controller) is GravityCompensatedPD
    before = first.tau.copy()
    cell.step(10)
    np.testing.assert_array_equal(first.tau, before)
    np.testing.assert_array_equal(cell.data.ctrl[robot.ctrl_adr], manager.controller.tau)
    manager.switch("computed_torque")
    assert manager.controller is first
    cell.step(10)
    before = manager.get_state()
    manager.switch("computed_torque")  # it is active
    assert manager.get_state() == before


@pytest.mark.parametrize(("active", "steps"), [("computed_torque", 0), ("pd", 0), ("pd", 40)])
def test_from_a_state_also_during_a_transfer_it_continues_bit_for_bit(make, active, steps):
    cell, robot, manager = make(load=LOAD)
    manager.reference = Hold(robot.q)
    manager.controller.payload = Payload(0.2)
    cell.step(300)
    manager.switch(active)
    cell.step(steps)
    state, physics, q_ref = json.dumps(manager.get_state()), cell.snapshot(), manager.reference.q
    cell.step(300)

    other, _, restored = make()
    other.restore(physics)
    restored.reference = Hold(q_ref)
    restored.set_state(json.loads(state))
    assert restored.active == active
    other.step(300)
    assert other.state_bytes() == cell.state_bytes()


def test_the_next_controller_begins_anew_with_the_payload_and_the_count_of_saturated_steps(make):
    cell, robot, manager = make()
    manager.controller.payload = payload = Payload(0.5)
    manager.controller.saturated_steps = 3
    manager.switch("pd")
    assert manager.controller.payload is payload
    assert manager.controller.saturated_steps == 3
    other = manager.get("computed_torque")
    other.saturated_steps, other.tau = 70, np.full_like(other.tau, 5.0)
    manager.activate("computed_torque")
    assert manager.controller.saturated_steps == 3
    assert not manager.controller.tau.any()


def test_the_default_controller_returns_once_the_reference_is_at_rest(make):
    cell, robot, manager = make()
    manager.reference = wave = Wave(robot.q, 0.25, 4.0)
    cell.step(100)
    manager.switch("pd")
    manager.return_to_default()
    cell.step(50)
    assert manager.active == "pd"
    wave.amplitude = 0.0
    cell.step(2)
    assert manager.active == "computed_torque"


def test_an_unknown_controller_or_one_that_fails_does_not_become_active(make):
    cell, robot, manager = make()
    with pytest.raises(ControlError, match="'computed_torqe'; did you mean 'computed_torque'"):
        manager.switch("computed_torqe")
    cell.step(10)
    with pytest.raises(ControllerFault, match="controller 'broken' raised ValueError: no torques"):
        manager.switch("broken")
    assert manager.active == "computed_torque"
    cell.step(500)
    np.testing.assert_allclose(robot.q, manager.reference.q, atol=1e-3)


def test_an_episode_of_a_plain_environment_begins_with_the_default_controller(make):
    cell, _, manager = make()
    environment = composer.Environment(composer.NullTask(cell.arena), random_state=0)
    environment.reset()
    manager.switch("pd")
    environment.step(np.zeros(environment.physics.model.nu))
    assert manager.active == "pd"
    environment.reset()
    assert manager.active == manager.default == "computed_torque"


@pytest.mark.parametrize("default", ["computed_torque", "pd"])
def test_the_models_of_controllers_have_no_overrides(make, default):
    cell, robot, manager = make(default)
    bare = robot.make_model()
    cell.override("two_links", joint_friction=[5.0, 5.0])
    assert robot.make_model().friction.tolist() == [5.0, 5.0]
    for name in (default, "unclipped"):
        assert manager.get(name).model.friction.tolist() == bare.friction.tolist()
