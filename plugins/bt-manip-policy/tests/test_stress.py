"""The tree with a policy is honest under all faults."""

from functools import partial

import numpy as np
import pytest

from bt_manip.evaluation import run_episodes
from bt_manip.record import Recorder
from bt_manip.runner import prepare, request_of
from bt_manip_stress import StressTester, plan_episodes

from . import onnx_files as onnx
from .test_contracts import SETTINGS


def test_a_cube_that_is_displaced_at_the_end_is_picked_by_the_script(parts, tmp_path):
    failing = tmp_path / "failing.onnx"  # at once
    failing.write_bytes(onnx.linear([np.nan] * 7, {"robot_tool_position": (3,)}))
    settings, faults = {"policy": str(failing)}, {"fault": ("move at=Drop",)}
    request = request_of("pick_place_policy", parts, settings=settings, modifiers=faults)
    recorder = Recorder("pick_place_policy", 0)
    prepare(request, parts).execute([recorder])
    (cycle,) = recorder.report().cycles
    assert (cycle.status, cycle.placed) == ("SUCCESS", True)
    assert [phase.behaviour for phase in cycle.phases].count("Grasp") == 2


@pytest.mark.soak
def test_every_fault_at_every_phase_ends_honestly_and_the_next_cycle_succeeds():
    settings = SETTINGS["pick_place_policy"]  # a policy that does not pick
    tester = partial(StressTester, "pick_place_policy", settings=settings)
    results = run_episodes(tester, plan_episodes(tester(), 1), 2)
    assert not [result for result in results if not result.acceptable]
