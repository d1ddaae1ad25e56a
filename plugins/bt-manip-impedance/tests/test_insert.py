"""A held peg is inserted with a limited force, and the arm gets its controller back."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.behaviours import Grasp, Hover, Lift, OpenGripper, Reach, extent
from bt_manip.bt import NodeStatus, Tree
from bt_manip.testing import Trial, play
from bt_manip_impedance import Insert
from bt_manip_impedance.insert import spiral

TOO_NARROW = 0.0145  # [m] radius of a hole that the peg of 15 mm does not fit into
OFFSET = (0.0005, -0.001)  # [m] of a hole from the middle of the board


@pytest.fixture(scope="module")
def holding_the_peg(parts):
    """Give a function that returns a station whose robot holds the peg, for a scene and board."""

    @cache
    def built(name, board):
        scene = parts.scenes.create(name)
        *others, socket = scene.objects
        socket = replace(socket, parameters={**socket.parameters, **dict(board)})
        station = build_station(parts, scene=replace(scene, objects=(*others, socket)))
        play(station, Hover(object="peg", height=0.15), Reach(object="peg"))
        play(station, Grasp(object="peg", force=40.0), Lift(height=0.15))
        return station, station.get_state()

    def holding_the_peg(scene="peg_on_table", **board):
        station, state = built(scene, tuple((board or {"hole": TOO_NARROW}).items()))
        station.set_state(state)
        return station

    return holding_the_peg


def force_on_the_board(station) -> float:
    return float(np.linalg.norm(station.cell.contacts.wrench("board").force))


def failed_insertion(station, **ports):
    """Insert until the arm has its own controller again; return the reason, and forces [N]."""
    trial, forces = Trial(station, Insert("insert", object="peg", socket="board", **ports)), []
    while trial.tick() is NodeStatus.RUNNING:
        forces.append(force_on_the_board(station))
    station.step_until(lambda: station.controllers.active == "computed_torque")
    station.cell.step(150)
    return trial.tree.failure_reason(), forces


def test_in_a_hole_that_is_too_narrow_the_stiffness_limits_the_force(holding_the_peg):
    station = holding_the_peg()
    reason, forces = failed_insertion(station)
    assert "stopped 0.0 mm deep in 'board'" in reason
    assert sorted(forces)[-20] < 31.0  # 1000 N/m times 30 mm, apart from the impact
    assert force_on_the_board(station) < 2.0  # let go of softly


def test_a_stiff_controller_exceeds_the_allowed_force(holding_the_peg):
    reason, _ = failed_insertion(holding_the_peg(), controller="computed_torque")
    assert "at most 30 N are allowed" in reason


def test_a_hole_outside_of_the_searched_circle_is_not_found(holding_the_peg):
    station = holding_the_peg("peg_in_hole", offset=OFFSET)  # 1.12 mm, of which 0.5 mm are play
    reason, forces = failed_insertion(station, search=0.0003)
    assert "found no hole within 0.3 mm" in reason
    assert max(forces) < 15.0


def test_the_peg_is_lowered_pressed_moved_on_a_spiral_and_pushed_where_it_caught(
    holding_the_peg, monkeypatch
):
    station = holding_the_peg("peg_in_hole", offset=OFFSET)
    arm, data, moves = station.arm, station.cell.data, []
    peg = int(station.cell.model.jnt_qposadr[station.cell.model.body("peg/").jntadr[0]])
    for name in ("move_to_pose", "move_linear", "move_path"):
        monkeypatch.setattr(arm, name, lambda *given, **more: moves.append((*given, more)))
    top, at = extent(station.cell, "board")[1][2], station.cell.pose("board").translation
    leaf = Insert("insert", object="peg", socket="board", search=0.004)
    tree = Tree(leaf, clock=station.clock)
    tree.setup(**station.infrastructure)

    def tick(depth):
        """Tick with the bottom of the peg at a depth; return a new motion, or the status."""
        data.qpos[peg + 2] += top - depth - extent(station.cell, "peg")[0][2]
        mujoco.mj_kinematics(station.cell.model, data)
        before, status = len(moves), tree.tick()
        return moves[-1] if len(moves) > before else status

    def bottom(T):
        """Return the bottom of the held peg and its axis, with the tool at a pose."""
        T_wo = T * station.robot.tool_pose.actInv(station.cell.pose("peg"))
        return T_wo.act(np.array([0.0, 0.0, -0.045])), T_wo.rotation[:, 2]

    assert tree.tick() is NodeStatus.RUNNING
    for (T, given), height, expected in zip(
        moves, (0.005, -0.006), ({"speed": 1.0}, {"speed": 0.04, "contact": True}), strict=True
    ):  # 6 mm are 6 N at 1000 N/m
        place, axis = bottom(T)
        assert place == pytest.approx((*at[:2], top + height), abs=2e-5)
        assert axis == pytest.approx((0.0, 0.0, 1.0), abs=1e-4) and given == expected
    steps, speed, given = tick(0.0014)
    assert (speed, given) == (0.2, {"blend": 0.0005, "contact": True})
    start = arm.model.pose(arm.q)
    circles = list(spiral(start.translation, 0.004, 0.0005))
    for step, (via, end) in zip(steps, circles, strict=True):
        assert step.via == pytest.approx(via, abs=2e-4)
        assert step.pose.translation == pytest.approx(end, abs=2e-4)
    assert tick(0.0014) is NodeStatus.RUNNING
    T, given = tick(0.0016)
    caught = station.cell.pose("peg").act(np.array([0.0, 0.0, -0.045]))
    assert bottom(T)[0] == pytest.approx((*caught[:2], top - 0.03), abs=5e-4)
    assert given == {"speed": 0.1, "contact": True}
    assert (tick(0.0279), tick(0.0281)) == (NodeStatus.RUNNING, NodeStatus.SUCCESS)


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
    assert Trial(station, behaviour).fails_with("the gripper does not hold 'peg'")
