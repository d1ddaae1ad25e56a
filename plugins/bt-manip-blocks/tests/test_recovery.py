"""The trees look at the end, and go on from the blocks as they are."""

import pytest

from bt_manip.bt import NodeStatus
from bt_manip_blocks import ChooseBase
from bt_manip_stress import StressTester, plan_episodes

from .test_blocks import put


def check_recovery(tree, fault, phase):
    tester = StressTester(tree)
    (episode,) = plan_episodes(tester, 1, [fault], [phase])
    result = tester.run(episode)
    assert (result.outcome, result.reason, result.next_reason) == ("recovered", "", "")


def test_a_tower_from_which_a_block_is_taken_at_the_end_is_built_again():
    check_recovery("stack_blocks", "move", "MoveHome")


@pytest.mark.soak
@pytest.mark.parametrize(
    ("fault", "phase"),
    [("sensor_delay", "Hover"), ("stuck_finger", "Hover"), ("stuck_joint", "Grasp")],
)
def test_all_blocks_are_sorted_slower_after_a_failure(fault, phase):
    check_recovery("sort_blocks", fault, phase)


def test_the_highest_tower_is_built_on(station, trial):
    for colour, x, y, z in (
        ("red", 0.3, -0.1, 0.02),
        ("green", 0.3, -0.1, 0.06),
        ("blue", 0.45, 0.05, 0.02),
        ("yellow", 0.3, -0.19, 0.02),
    ):
        put(station, colour, x, y, z)
    station.cell.step(50)
    choosing = trial(ChooseBase(base="{base}", top="{top}"))
    assert choosing.tick() is NodeStatus.SUCCESS
    assert choosing.blackboard["base"] == "red" and choosing.blackboard["top"] == "green"
