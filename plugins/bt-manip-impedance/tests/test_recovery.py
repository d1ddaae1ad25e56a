"""The trees look at the end, and try again after disturbances."""

from functools import cache

import pytest

from bt_manip_stress import StressEpisode, StressTester


@pytest.fixture(scope="module")
def recovers():
    """Tell how a tree fares with a fault at the last phase of that name."""

    @cache
    def tested(tree):
        tester = StressTester(tree)
        return tester, tester.phases()

    def recovers(tree, fault, phase, seed):
        tester, phases = tested(tree)
        where = [one for one in phases if phase in one.path][-1]
        result = tester.run(StressEpisode(fault, where, seed))
        return result.outcome, result.reason, result.next_reason

    return recovers


SOAKED = [
    ("open_drawer", "torque_loss", "OpenGripper", 1),
    ("open_drawer", "torque_loss", "OpenGripper", 2),
    ("press_button", "push", "Press", 0),
    ("press_button", "stuck_joint", "MoveHome", 0),
    ("press_button", "sensor_delay", "Hover", 0),
    ("insert_peg", "move", "MoveHome", 0),  # it is knocked out of the hand
    ("peg_in_hole", "sensor_delay", "Grasp", 0),  # it is carried slower afterwards
    ("hand_over", "move", "MoveToPose", 1),
    ("hand_over", "move", "MoveHome", 0),
]


@pytest.mark.parametrize(
    ("tree", "fault", "phase", "seed"),
    [
        ("open_drawer", "torque_loss", "OpenGripper", 0),  # the falling arm pushes the drawer
        *(pytest.param(*case, marks=pytest.mark.soak) for case in SOAKED),
    ],
)
def test_a_task_is_done_in_spite_of_a_disturbance(recovers, tree, fault, phase, seed):
    assert recovers(tree, fault, phase, seed) == ("recovered", "", "")


@pytest.mark.soak
def test_a_rod_that_is_jammed_between_both_grippers_is_dropped_and_handed_over_again(recovers):
    found = [recovers("hand_over", "torque_loss", "Approach", seed) for seed in range(3)]
    assert found.count(("recovered", "", "")) >= 2  # where it falls to differs between CPUs
    assert {outcome for outcome, _, _ in found} <= {"recovered", "failed"}
