"""The tree with a policy is honest under all faults."""

from functools import partial

import pytest

from bt_manip.evaluation import run_episodes
from bt_manip_stress import StressTester, plan_episodes

from .test_contracts import IDLE


@pytest.fixture
def tester():
    """Return what makes the tester of the tree, with a policy that does not pick."""
    return partial(StressTester, "pick_place_policy", settings={"policy": str(IDLE)})


def test_a_cube_that_is_displaced_at_the_end_is_picked_by_the_script(tester):
    (episode,) = plan_episodes(tester(), 1, ["move"], ["Drop"])
    result = tester().run(episode)
    assert (result.outcome, result.reason, result.next_reason) == ("recovered", "", "")


@pytest.mark.soak
def test_every_fault_at_every_phase_ends_honestly_and_the_next_cycle_succeeds(tester):
    results = run_episodes(tester, plan_episodes(tester(), 1), 2)
    assert not [result for result in results if not result.acceptable]
