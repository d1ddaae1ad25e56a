"""The trees look at the end, and clear the table after a failure."""

from functools import cache

import pytest

from bt_manip_stress import StressEpisode, StressTester

SETTINGS = {  # for short cycles
    "cans_into_box": {"sentence": "put the red can into the box", "distractors": "0"},
    "mug_on_shelf": {},
}


@pytest.fixture(scope="module")
def run():
    """Give a function that returns the result of an episode of a tree with a fault in a phase."""

    @cache
    def tested(tree):
        tester = StressTester(tree, settings=SETTINGS[tree])
        return tester, {phase.name: phase for phase in tester.phases()}

    def run(tree, fault, phase):
        tester, phases = tested(tree)
        result = tester.run(StressEpisode(fault, phases[phase], 0))
        return result.outcome, result.reason, result.next_reason

    return run


def test_a_can_that_is_moved_away_at_the_end_is_put_into_the_box_again(run):
    assert run("cans_into_box", "move", "retreat") == ("recovered", "", "")


def test_without_its_box_it_fails_and_the_next_cycle_has_room_for_one(run):
    outcome, reason, next_reason = run("cans_into_box", "container_vanishes", "retreat")
    assert outcome == "failed" and "there is no 'box" in reason
    assert next_reason == ""


@pytest.mark.parametrize(
    ("fault", "phase"),
    [("sensor_delay", "Hover"), pytest.param("stuck", "PlaceOn", marks=pytest.mark.soak)],
)
def test_a_mug_is_picked_slower_or_again_after_the_arm_was_stopped(run, fault, phase):
    assert run("mug_on_shelf", fault, phase) == ("recovered", "", "")
