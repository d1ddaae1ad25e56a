"""The trees look at the end, and clear the table after a failure."""

import pytest

from bt_manip_stress import StressTester, plan_episodes


def run(tree, fault, phase):
    tester = StressTester(tree)
    (episode,) = plan_episodes(tester, 1, [fault], [phase])
    result = tester.run(episode)
    return result.outcome, result.reason, result.next_reason


def test_a_can_that_is_moved_away_at_the_end_is_put_into_the_box_again():
    assert run("cans_into_box", "move", "retreat") == ("recovered", "", "")


def test_without_its_box_it_fails_and_the_next_cycle_has_room_for_one():
    outcome, reason, next_reason = run("cans_into_box", "container_vanishes", "retreat")
    assert outcome == "failed" and "there is no 'box" in reason
    assert next_reason == ""


@pytest.mark.parametrize(("fault", "phase"), [("sensor_delay", "Hover"), ("stuck", "PlaceOn")])
def test_a_mug_is_picked_slower_or_again_after_the_arm_was_stopped(fault, phase):
    assert run("mug_on_shelf", fault, phase) == ("recovered", "", "")
