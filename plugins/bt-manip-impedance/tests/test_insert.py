"""A held peg is inserted with a limited force, and the arm gets its controller back."""

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.behaviours import Grasp, Hover, Lift, OpenGripper, Reach, extent
from bt_manip.bt import NodeStatus, Tree
from bt_manip_impedance import Insert
from bt_manip_impedance.insert import spiral

TOO_NARROW = 0.0145  # [m] radius of a hole that the peg of 15 mm does not fit into


@pytest.fixture(scope="module")
def holding_the_peg(parts):
    """Give a function that returns a station of a scene whose robot holds the peg."""
    made = {}

    def holding_the_peg(scene="peg_on_table", **board):
        key = (scene, *board.items())
        if key not in made:
            station = build_with_peg(parts, scene, board)
            made[key] = station, station.get_state()
        station, state = made[key]
        station.set_state(state)
        return station

    return holding_the_peg


def build_with_peg(parts, scene, board):
    scene = parts.scenes.create(scene)
    *others, socket = scene.objects
    socket = replace(socket, parameters={**socket.parameters, **board})
    station = build_station(parts, scene=replace(scene, objects=(*others, socket)))
    for behaviour in (
        Hover("hover", object="peg", height=0.15),
        Reach("reach", object="peg"),
        Grasp("grasp", object="peg", force=40.0),
        Lift("lift", height=0.15),
    ):
        assert station.run(behaviour).status is NodeStatus.SUCCESS
    return station


def insert(station, **ports):
    """Run an insertion; return it, its status, and the controller and force of each tick."""
    behaviour = Insert("insert", object="peg", socket="board", **ports)
    tree = Tree(behaviour, clock=station.clock)
    tree.setup(**station.infrastructure)
    active, forces, status = [], [], NodeStatus.RUNNING
    for _ in range(2000):
        if status is NodeStatus.RUNNING:
            status = tree.tick()
        elif station.controllers.active == station.controllers.default:
            break
        station.cell.step(10)
        active.append(station.controllers.active)
        forces.append(float(np.linalg.norm(station.cell.contacts.wrench("board").force)))
    station.cell.step(150)
    return behaviour, status, [name for name, _ in groupby(active)], forces


def test_in_a_hole_that_is_too_narrow_the_stiffness_limits_the_force(holding_the_peg):
    station = holding_the_peg(hole=TOO_NARROW)
    behaviour, status, active, forces = insert(station)
    assert status is NodeStatus.FAILURE
    assert "stopped 0.0 mm deep in 'board'" in behaviour.feedback_message
    assert sorted(forces)[-20] < 31.0  # 1000 N/m times 30 mm, apart from the impact
    assert active[-1] == "computed_torque"
    assert np.linalg.norm(station.cell.contacts.wrench("board").force) < 2.0  # let go of softly


def test_a_stiff_controller_exceeds_the_allowed_force(holding_the_peg):
    station = holding_the_peg(hole=TOO_NARROW)
    behaviour, status, _, _ = insert(station, controller="computed_torque")
    assert status is NodeStatus.FAILURE
    assert "at most 30 N are allowed" in behaviour.feedback_message


def test_a_hole_that_is_not_where_it_should_be_is_found_under_the_compliant_controller(
    holding_the_peg,
):
    station = holding_the_peg("peg_in_hole", offset=(0.0005, -0.001))
    behaviour, status, active, forces = insert(station, search=0.004)
    assert status is NodeStatus.SUCCESS, behaviour.feedback_message
    assert active == ["computed_torque", "cartesian_impedance", "computed_torque"]
    assert max(forces) < 30.0
    off = station.cell.pose("peg").translation - station.cell.pose("board").translation
    assert off[:2] == pytest.approx([0.0005, -0.001], abs=6e-4)
    bottom, top = extent(station.cell, "peg")[0], extent(station.cell, "board")[1]
    assert bottom[2] < top[2] - 0.027


def test_a_hole_outside_of_the_searched_circle_is_not_found(holding_the_peg):
    station = holding_the_peg("peg_in_hole", offset=(0.005, 0.0))
    behaviour, status, _, forces = insert(station, search=0.001)
    assert status is NodeStatus.FAILURE
    assert "found no hole within 1.0 mm" in behaviour.feedback_message
    assert max(forces) < 15.0


def test_the_half_circles_of_a_spiral_touch_and_cover_the_circle():
    centre, pitch = np.array([0.1, 0.2, 0.3]), 0.001
    start, found = centre, list(spiral(centre, 0.004, pitch))
    for via, end in found:
        middle = 0.5 * (start + end)
        assert np.linalg.norm(via - middle) == pytest.approx(0.5 * np.linalg.norm(end - start))
        start = end
    ends = np.array([centre, *(end for _, end in found)])
    sides = np.array([via for via, _ in found]) - 0.5 * (ends[1:] + ends[:-1])
    assert (np.sign(sides[:, 1]) == np.sign(np.diff(ends[:, 0]))).all()  # all turn the same way
    assert not (ends - centre)[:, 1:].any()
    reached = [np.linalg.norm(end - centre) for _, end in found]
    assert reached == pytest.approx(pitch / 2 * np.arange(1, 10))
    assert min(reached[-2:]) >= 0.004


def test_an_insertion_that_is_halted_gives_the_arm_its_controller_back(holding_the_peg):
    station = holding_the_peg()
    tree = Tree(Insert("insert", object="peg", socket="board"), clock=station.clock)
    tree.setup(**station.infrastructure)
    while station.controllers.active == "computed_torque":
        assert tree.tick() is NodeStatus.RUNNING
        station.cell.step(10)
    tree.halt()
    station.step_until(lambda: not station.arm.moving)
    station.cell.step()
    assert station.controllers.active == "computed_torque"


def test_an_object_that_is_not_held_is_not_inserted(holding_the_peg):
    station = holding_the_peg()
    assert station.run(OpenGripper("let go")).status is NodeStatus.SUCCESS
    behaviour = Insert("insert", object="peg", socket="board")
    assert station.run(behaviour).status is NodeStatus.FAILURE
    assert behaviour.feedback_message == "the gripper does not hold 'peg'"
