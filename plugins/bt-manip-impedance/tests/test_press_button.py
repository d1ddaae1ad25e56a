"""A button is pressed, counted and released."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.behaviours import CloseGripper, Hover
from bt_manip.bt import NodeStatus, Sequence, Tree
from bt_manip.cell import Cell
from bt_manip.runner import request_of
from bt_manip_impedance import Drawer, IsOpen, Press, PushButton, WasPressed
from bt_manip_learn.agents import Episodes, goal_progress


@pytest.mark.parametrize("controller", ["cartesian_impedance", "computed_torque"])
def test_a_compliant_arm_presses_the_button_and_a_stiff_one_exceeds_the_force(parts, controller):
    scene = parts.scenes.create(parts.tree_defaults["press_button"].scene)
    station = build_station(parts, controller=controller, scene=scene)
    root = Sequence("press", CloseGripper(force=10.0), Hover(object="button", height=0.06),
                    Press(object="button", hold=0.1, max_force=40.0))  # fmt: skip
    tree, button, depths = Tree(root, clock=station.clock), station.cell.find("button"), []
    tree.setup(**station.infrastructure)
    while (status := tree.tick()) is NodeStatus.RUNNING:
        station.cell.step(10)
        depths.append(button.depth)
    assert button.depth < 1e-4
    if controller == "computed_torque":
        assert status is NodeStatus.FAILURE
        assert "at most 40 N are allowed" in tree.failure_reason()
    else:
        assert status is NodeStatus.SUCCESS, tree.failure_reason()
        assert 0.1 <= 0.01 * sum(depth > 0.95 * 0.008 for depth in depths) < 0.3  # [s] held down


def test_a_press_is_counted_once_and_kept_in_a_snapshot(parts):
    station = build_station(parts, scene=parts.scenes.create("press_button"))
    cell, button = station.cell, station.cell.find("button")
    before = cell.snapshot()
    assert station.run(WasPressed("pressed", object="button")).status is NodeStatus.FAILURE
    dof = cell.model.joint("button/press").dofadr[0]
    for force in (15.0, 0.0):
        cell.data.qfrc_applied[dof] = force
        cell.step(300)
    assert button.presses == 1
    assert station.run(WasPressed("pressed", object="button")).status is NodeStatus.SUCCESS
    after = cell.snapshot()
    cell.restore(before)
    assert button.presses == 0
    cell.restore(after)
    assert button.presses == 1


def test_progress_is_that_of_the_nearest_tool_and_of_the_cap_or_the_drawer():
    cell, hand = Cell(), SimpleNamespace(held=())
    with cell.editing():
        cell.add(PushButton(travel=0.01), spatial.pose((0.3, -0.2, 0.1)), name="button")
        at = spatial.pose((0.1, 0.6, 0.2), (np.cos(0.2), 0.0, 0.0, np.sin(0.2)))
        cell.add(Drawer(), at, name="drawer")
    places = (0.3, -0.1, 0.15), (0.0, 0.5, 0.3)
    tools = [SimpleNamespace(tool_pose=spatial.pose(place)) for place in places]
    robots = dict(enumerate(SimpleNamespace(gripper=hand, robot=tool) for tool in tools))
    pressed = WasPressed("pressed", object="button", released=True)
    is_open = IsOpen("open", object="drawer", opening=0.1)
    for condition in (pressed, is_open):
        condition.setup(cell=cell, robots=robots)
    button, drawer = (
        cell.model.joint(name).qposadr[0] for name in ("button/press", "drawer/slide")
    )
    cell.data.qpos[[button, drawer]] = 0.004, 0.03
    near = 1.0 - np.tanh(np.hypot(0.1, 0.15 - 0.132) / 0.2)  # the cap's top is 3.2 cm high
    assert pressed.progress() == pytest.approx(0.4 * near + 0.4 * 0.4)
    handle = at.act(np.array([-0.15 - 0.03 - 0.04, 0.0, 0.06]))
    near = 1.0 - np.tanh(np.linalg.norm(handle - places[1]) / 0.2)
    assert is_open.progress() == pytest.approx(0.2 * max(near, 0.3) + (0.2 + 0.6) * 0.3)
    hand.held = ("drawer",)
    assert is_open.progress() == pytest.approx(0.2 * max(near, 0.3) + 0.2 + 0.6 * 0.3)
    for opening, speed, met in ((0.099, 0.0, 0), (0.101, 0.004, 1), (0.101, -0.006, 0)):
        cell.data.qpos[drawer], cell.data.qvel[-1] = opening, speed
        assert (is_open.why_not() == "") == met
    cell.find("button").pressed_at = 0.1
    assert pressed.progress() == pytest.approx(0.8 + 0.2 * 0.6)
    for depth, met in ((0.9e-4, 1), (1.1e-4, 0)):
        cell.data.qpos[button] = depth
        assert (pressed.why_not() == "") == met


def test_progress_grows_from_the_approach_to_the_release(parts):
    episodes = Episodes(request_of("press_button", parts), parts)
    episodes.reset(0)
    button, found = episodes.station.cell.find("button"), [(0.0, goal_progress(episodes))]
    while not episodes.success:
        episodes.expert_step()
        found.append((button.depth, goal_progress(episodes)))
    assert found[0][1] < 0.25 and found[-1][1] == 1.0
    first = next(i for i, (depth, _) in enumerate(found) if depth > 1e-3)
    assert max(progress for _, progress in found[:first]) < 0.5  # over the button
    pressing = [progress for _, progress in found[first:]]
    assert all(after > before - 0.01 for before, after in itertools.pairwise(pressing))
