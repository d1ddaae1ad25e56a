"""A drawer is pulled open by its handle, with a limited force."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.behaviours import CloseGripper
from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import Cell
from bt_manip.grippers import TwoFingerGripper
from bt_manip.testing import Trial
from bt_manip_impedance import Drawer, IsOpen, PullOpen, ReachHandle

TURN = spatial.pose((0.0, 0.0, 0.0), (math.cos(0.2), 0.0, 0.0, math.sin(0.2)))


@pytest.fixture(scope="module")
def built(parts):
    """Return a station of the drawer, and its states before and while the handle is held."""
    station = build_station(parts, scene=parts.scenes.create("open_drawer"))
    states = [station.get_state()]
    for behaviour in (ReachHandle("reach", object="drawer"), CloseGripper("close", force=50.0)):
        assert station.run(behaviour).status is NodeStatus.SUCCESS
    return station, (*states, station.get_state())


@pytest.fixture
def at_the_handle(built):
    """Give a function that returns the station, with a friction of the slide [N]."""

    def at_the_handle(resistance=10.0, held=True):
        station, states = built
        station.set_state(states[held])
        slide = station.cell.model.joint("drawer/slide").dofadr[0]
        station.cell.model.dof_frictionloss[slide] = resistance
        return station

    return at_the_handle


@pytest.fixture
def moves(built, monkeypatch):
    """Record the motions of the arm, instead of moving it."""
    moves = []
    for name in ("move_to_pose", "move_linear"):
        monkeypatch.setattr(built[0].arm, name, lambda T, **given: moves.append((T, given)))
    return moves


def test_the_gripper_moves_over_the_handle_of_a_turned_drawer_and_then_down(
    at_the_handle, moves, monkeypatch
):
    station = at_the_handle(held=False)
    T_wd = station.cell.pose("drawer") * TURN
    monkeypatch.setattr(station.cell, "pose", lambda name: T_wd)
    leaf = ReachHandle("reach", object="drawer")
    leaf.setup(**station.infrastructure)
    for begin in (leaf.start, leaf.begin_again, leaf.arrived, leaf.begin_again):
        begin()
    (over, given), over_again, (down, slowly), down_again = moves
    assert over_again[1] == given and down_again[1] == slowly  # after it was blocked
    handle = T_wd.act(np.array([-0.15 - 0.04, 0.0, 0.06]))
    assert given == {"speed": 1.0, "approach": 0.12} and slowly == {"speed": 1.0}
    for T, side in zip(over, (1.0, -1.0), strict=True):
        assert T.translation == pytest.approx(handle + (0.0, 0.0, 0.12))
        assert T.rotation[:, 0] == pytest.approx(side * T_wd.rotation[:, 0])
        assert T.rotation[:, 2] == pytest.approx((0.0, 0.0, -1.0))
    assert down.translation == pytest.approx(handle)
    assert down.rotation[:, 2] == pytest.approx((0.0, 0.0, -1.0))
    assert down.rotation[:, 0] @ station.robot.tool_pose.rotation[:, 0] > 0.0  # the nearer one


def test_a_drawer_that_is_stuck_is_not_pulled_with_more_than_the_allowed_force(at_the_handle):
    station = at_the_handle(resistance=200.0)
    behaviour = PullOpen("pull", object="drawer", max_force=20.0)
    assert Trial(station, behaviour).fails_with("at most 20 N are allowed")
    assert station.cell.find("drawer").opening < 0.01


@pytest.mark.parametrize(
    ("opened", "reason"),
    [
        (0.0, "'drawer' stopped 0 mm open, expected 150 mm"),
        (0.1549, "the handle of 'drawer' was lost 155 mm open"),
        (0.1551, ""),
    ],
)
def test_the_tool_goes_3_cm_farther_than_asked_and_a_drawer_is_open_5_mm_beyond_it(
    at_the_handle, moves, opened, reason
):
    station = at_the_handle()
    slide, start = station.cell.data.joint("drawer/slide"), station.robot.tool_pose
    slide.qpos = before = min(opened, 0.01)
    leaf = PullOpen("pull", object="drawer")
    tree = Tree(leaf, clock=station.clock)
    tree.setup(**station.infrastructure)
    while (status := tree.tick()) is NodeStatus.RUNNING:
        slide.qpos, slide.qvel = opened, 0.0
        station.cell.step(10)
        slide.qpos, slide.qvel = opened, 0.0
    assert (leaf.feedback_message if status is NodeStatus.FAILURE else "") == reason
    ((T, given),) = moves
    away = station.cell.pose("drawer").rotation.T @ (T.translation - start.translation)
    assert away == pytest.approx((before - 0.15 - 0.03, 0.0, 0.0), abs=2e-4)
    assert given == {"speed": 0.2, "contact": True}


def test_a_handle_that_is_not_held_is_not_pulled_and_no_drawer_beyond_its_travel(at_the_handle):
    station, is_open = at_the_handle(held=False), IsOpen("open", object="drawer")
    assert Trial(station, is_open).fails_with("'drawer' is 0 mm open")
    assert 0.0 < is_open.progress() < 0.2
    for opening, reason in (
        (0.1949, "the gripper does not hold 'drawer'"),
        (0.1951, "'drawer' opens by 0.2 m at most"),
    ):
        behaviour = PullOpen("pull", object="drawer", opening=opening)
        assert Trial(station, behaviour).fails_with(reason)


def test_progress_is_that_of_the_nearest_tool_of_the_grip_and_of_the_drawer():
    cell, hand = Cell(), SimpleNamespace(held=())
    at = spatial.pose((0.1, 0.6, 0.2)) * TURN
    cell.add(Drawer(), at, name="drawer")
    places = (0.3, -0.1, 0.15), (0.0, 0.5, 0.3)
    tools = [SimpleNamespace(tool_pose=spatial.pose(place)) for place in places]
    robots = dict(enumerate(SimpleNamespace(gripper=hand, robot=tool) for tool in tools))
    is_open = IsOpen("open", object="drawer", opening=0.1)
    is_open.setup(cell=cell, robots=robots)
    cell.data.qpos[0] = 0.03
    handle = at.act(np.array([-0.15 - 0.03 - 0.04, 0.0, 0.06]))
    near = 1.0 - np.tanh(np.linalg.norm(handle - places[1]) / 0.2)
    assert is_open.progress() == pytest.approx(0.2 * max(near, 0.3) + (0.2 + 0.6) * 0.3)
    hand.held = ("drawer",)
    assert is_open.progress() == pytest.approx(0.2 * max(near, 0.3) + 0.2 + 0.6 * 0.3)
    for opening, speed, met in ((0.099, 0.0, 0), (0.101, 0.004, 1), (0.101, -0.006, 0)):
        cell.data.qpos[0], cell.data.qvel[0] = opening, speed
        assert (is_open.why_not() == "") == met


def test_a_handle_that_is_too_thin_for_the_gripper_is_found_before_a_run(
    at_the_handle, monkeypatch
):
    leaf = PullOpen("pull", object="drawer")
    leaf.setup(**at_the_handle().infrastructure)
    for least, reason in (
        (0.0159, ""),
        (0.02, "the gripper closes to 20.0 mm only, the handle of 'drawer' is 16 mm thick"),
    ):
        monkeypatch.setattr(TwoFingerGripper, "min_object_width", least)
        assert leaf.why_infeasible() == reason
