"""The tree press_button needs a compliant controller."""

import itertools

import pytest

from bt_manip import build_station
from bt_manip.bt import BehaviourRegistry, NodeStatus, load_tree
from bt_manip.plugins import load_plugins
from bt_manip.runner import request_of
from bt_manip_impedance import Press, WasPressed
from bt_manip_learn.agents import Episodes, goal_progress


@pytest.fixture(scope="module")
def parts():
    return load_plugins().parts


def press(parts, controller=None, scene=None, **ports):
    """Run the tree; return its status, failure reason, and the cap's largest and last depth."""
    wants = parts.tree_defaults["press_button"]
    station = build_station(
        parts,
        controller=controller or wants.controller,
        scene=scene or parts.scenes.create(wants.scene),
    )
    behaviours = BehaviourRegistry()
    for name in parts.behaviours.names():
        behaviours.register(parts.behaviours.get(name), name)
    tree = load_tree(parts.trees.get("press_button"), behaviours, clock=station.clock)
    defaults = {"button": "button", "hold": 0.1, "max_force": 40.0, "attempts": 1}
    for key, value in {**defaults, **ports}.items():
        tree.blackboard.set_text(key, str(value))
    button = station.cell.find("button")
    tree.setup(**station.infrastructure)
    depths = []
    while (status := tree.tick()) is NodeStatus.RUNNING:
        station.cell.step(10)
        depths.append(button.depth)
    reason = tree.failure_reason() if status is NodeStatus.FAILURE else ""
    return status, reason, max(depths), button.depth


def test_a_compliant_arm_presses_and_releases_the_button(parts):
    status, reason, deepest, at_end = press(parts)
    assert status is NodeStatus.SUCCESS, reason
    assert deepest > 0.95 * 0.008
    assert at_end < 1e-4


def test_a_stiff_arm_exceeds_the_force_and_releases_the_button(parts):
    status, reason, _, at_end = press(parts, controller="computed_torque")
    assert status is NodeStatus.FAILURE
    assert "at most 40 N are allowed" in reason
    assert at_end < 1e-4


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


def test_another_object_than_a_button_cannot_be_pressed(parts):
    station = build_station(parts)
    behaviour = Press("press", object="basket")
    assert station.run(behaviour).status is NodeStatus.FAILURE
    assert behaviour.feedback_message == "'basket' is not a button"
