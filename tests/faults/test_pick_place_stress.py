"""The tree pick_place is honest under all faults, and recovers from those that it can."""

from functools import partial

import pytest

from bt_manip.evaluation import run_episodes
from bt_manip.faults import StressTester, plan_cases

RECOVERED = {"move", "knock", "push", "obstacle", "stuck_finger", "tick_delay", "sensor_nan"}


def unacceptable(seeds, faults=(), phases=(), workers=1):
    tester = partial(StressTester, "pick_place")
    cases = plan_cases(tester(), seeds, faults, phases)
    return [
        result
        for result in run_episodes(tester, cases, workers)
        if not result.acceptable
        or (result.case.fault in RECOVERED and result.outcome not in ("recovered", "none"))
    ]


def test_a_cube_that_is_knocked_out_of_the_hand_is_picked_again():
    assert not unacceptable(1, ["knock"], ["Lift"])


@pytest.mark.soak
def test_every_fault_at_every_phase_ends_honestly_and_the_next_cycle_succeeds():
    assert not unacceptable(5, workers=2)
