"""All trees are honest under all faults, and recover from those that they can."""

from functools import partial

import pytest

from bt_manip.evaluation import run_episodes
from bt_manip.plugins import load_plugins
from bt_manip_stress import StressTester, plan_episodes

RECOVERED = {"move", "knock", "push", "obstacle", "stuck_finger", "tick_delay", "sensor_nan"}
TREES = [name for name in load_plugins().parts.trees.names() if name != "pick_place_policy"]


def results_of(tree, seeds, faults=(), phases=(), workers=1):
    tester = partial(StressTester, tree)
    episodes = plan_episodes(tester(), seeds, faults, phases)
    return run_episodes(tester, episodes, workers)


def not_recovered(results):
    return [result for result in results if result.outcome not in ("recovered", "none")]


def test_a_cube_that_is_knocked_out_of_the_hand_is_picked_again():
    results = list(results_of("pick_place", 1, ["knock"], ["Lift"]))
    assert not not_recovered(results) and all(result.acceptable for result in results)


@pytest.mark.soak
def test_pick_place_recovers_from_all_that_it_can():
    results = list(results_of("pick_place", 5, workers=2))
    assert all(result.acceptable for result in results)
    assert not [one for one in not_recovered(results) if one.episode.fault in RECOVERED]


@pytest.mark.soak
@pytest.mark.parametrize("tree", TREES)
def test_every_fault_at_every_phase_ends_honestly_and_the_next_cycle_succeeds(tree):
    assert not [result for result in results_of(tree, 1, workers=2) if not result.acceptable]
