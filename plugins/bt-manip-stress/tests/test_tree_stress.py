"""All trees are honest under all faults, and recover from those that they can."""

from functools import partial

import pytest

from bt_manip.evaluation import run_episodes
from bt_manip.plugins import load_plugins
from bt_manip_stress import StressTester, plan_episodes

pytestmark = pytest.mark.soak

RECOVERED = {"move", "knock", "push", "obstacle", "stuck_finger", "tick_delay", "sensor_nan"}
TREES = [name for name in load_plugins().parts.trees.names() if name != "pick_place_policy"]


def results_of(tree, seeds):
    tester = partial(StressTester, tree)
    return run_episodes(tester, plan_episodes(tester(), seeds), 2)


def test_pick_place_recovers_from_all_that_it_can():
    results = list(results_of("pick_place", 5))
    assert all(result.acceptable for result in results)
    done = ("recovered", "none")
    assert not [r for r in results if r.episode.fault in RECOVERED and r.outcome not in done]


@pytest.mark.parametrize("tree", TREES)
def test_every_fault_at_every_phase_ends_honestly_and_the_next_cycle_succeeds(tree):
    assert not [result for result in results_of(tree, 1) if not result.acceptable]


@pytest.mark.parametrize(
    ("tree", "fault", "phase"),
    [
        ("two_arms", "sensor_delay", "left/the second/Hover"),
        ("pick_place_cluttered", "sensor_noise", "the second/attempt/Drop"),
    ],
)
def test_a_tree_recovers_from(tree, fault, phase):
    tester = StressTester(tree)
    (phase,) = [one.name for one in tester.phases() if one.name.startswith(f"{phase}::")]
    (episode,) = plan_episodes(tester, 1, [fault], [phase])
    result = tester.run(episode)
    assert (result.outcome, result.reason, result.next_reason) == ("recovered", "", "")
