"""The tree with a policy is honest under all faults."""

from functools import partial

import pytest

from bt_manip.evaluation import run_episodes
from bt_manip.record import Recorder
from bt_manip.runner import prepare, request_of
from bt_manip_stress import StressTester, plan_episodes

from .test_contracts import SETTINGS

POLICY = SETTINGS["pick_place_policy"]  # which does not pick


def test_a_cube_that_is_displaced_at_the_end_is_picked_by_the_script(parts):
    faults = {"fault": ("move at=Drop",)}
    request = request_of("pick_place_policy", parts, settings=POLICY, modifiers=faults)
    recorder = Recorder("pick_place_policy", 0)
    prepare(request, parts).execute([recorder])
    (cycle,) = recorder.report().cycles
    assert (cycle.status, cycle.placed) == ("SUCCESS", True)
    assert [phase.behaviour for phase in cycle.phases].count("Grasp") == 2


@pytest.mark.soak
def test_every_fault_at_every_phase_ends_honestly_and_the_next_cycle_succeeds():
    tester = partial(StressTester, "pick_place_policy", settings=POLICY)
    results = run_episodes(tester, plan_episodes(tester(), 1), 2)
    assert not [result for result in results if not result.acceptable]
