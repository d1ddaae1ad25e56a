"""The trees look at the end, and clear the table after a failure."""

import pytest

from bt_manip.evaluation import StressTester, plan_episodes


@pytest.fixture(scope="module")
def tester():
    return StressTester("cans_into_box")


def test_a_can_that_is_moved_away_at_the_end_is_put_into_the_box_again(tester):
    (episode,) = plan_episodes(tester, 1, ["move"], ["retreat"])
    result = tester.run(episode)
    assert (result.outcome, result.reason, result.next_reason) == ("recovered", "", "")


def test_without_its_box_it_fails_and_the_next_cycle_has_room_for_one(tester):
    (episode,) = plan_episodes(tester, 1, ["container_vanishes"], ["retreat"])
    result = tester.run(episode)
    assert result.outcome == "failed" and "there is no 'box" in result.reason
    assert result.next_reason == ""


@pytest.mark.parametrize(("fault", "phase"), [("sensor_delay", "Hover"), ("stuck", "PlaceOn")])
def test_a_mug_is_picked_slower_or_again_after_the_arm_was_stopped(fault, phase):
    tester = StressTester("mug_on_shelf")
    (episode,) = plan_episodes(tester, 1, [fault], [phase])
    result = tester.run(episode)
    assert (result.outcome, result.reason, result.next_reason) == ("recovered", "", "")
