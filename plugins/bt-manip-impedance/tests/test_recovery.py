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

    def recovers(tree, fault, phase, seed=0):
        tester, phases = tested(tree)
        where = [one for one in phases if phase in one.path][-1]
        result = tester.run(StressEpisode(fault, where, seed))
        return result.outcome, result.reason, result.next_reason

    return recovers


@pytest.mark.parametrize(
    "seed", [0, pytest.param(1, marks=pytest.mark.soak), pytest.param(2, marks=pytest.mark.soak)]
)
def test_a_drawer_that_the_falling_arm_pushes_is_pulled_again(recovers, seed):
    found = recovers("open_drawer", "torque_loss", "OpenGripper", seed)
    assert found == ("recovered", "", "")


@pytest.mark.soak
@pytest.mark.parametrize(
    ("fault", "phase"), [("push", "Press"), ("stuck_joint", "MoveHome"), ("sensor_delay", "Hover")]
)
def test_a_button_is_pressed_in_spite_of_a_disturbance(recovers, fault, phase):
    assert recovers("press_button", fault, phase) == ("recovered", "", "")


@pytest.mark.soak
def test_a_peg_that_is_knocked_out_of_the_hand_is_inserted(recovers):
    assert recovers("insert_peg", "move", "MoveHome") == ("recovered", "", "")


@pytest.mark.soak
@pytest.mark.parametrize(("phase", "seed"), [("MoveToPose", 1), ("MoveHome", 0)])
def test_a_rod_that_is_moved_away_is_handed_over_again(recovers, phase, seed):
    assert recovers("hand_over", "move", phase, seed) == ("recovered", "", "")


@pytest.mark.soak
def test_a_rod_that_is_jammed_between_both_grippers_is_dropped_and_handed_over_again(recovers):
    found = [recovers("hand_over", "torque_loss", "Approach", seed) for seed in range(3)]
    assert found.count(("recovered", "", "")) >= 2  # where it falls to differs between CPUs
    assert {outcome for outcome, _, _ in found} <= {"recovered", "failed"}


@pytest.mark.soak
def test_a_peg_is_carried_slower_after_late_sensors_have_stopped_the_arm(recovers):
    assert recovers("peg_in_hole", "sensor_delay", "Grasp") == ("recovered", "", "")
