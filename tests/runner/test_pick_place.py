"""The whole task: placed by the physics' judgement, inside all limits, the same every time."""

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.record import Recorder
from bt_manip.runner import RunObserver, prepare, request_of
from bt_manip_recording import Trace

from .conftest import report_of

CYCLES = 2


@pytest.fixture(scope="module")
def traced(parts, tmp_path_factory):
    """Give the report, the trace and the digest of the first cycle."""
    path = tmp_path_factory.mktemp("run") / "trace.npz"
    run = prepare(request_of("pick_place", parts, cycles=CYCLES), parts)
    recorder, observer, digests = Recorder("pick_place", 0), RunObserver(), []
    observer.cycle_ended = lambda status, reason: digests.append(run.log.digest.hex())
    run.execute([recorder, Trace(path), observer])
    with np.load(path) as rows:
        return SimpleNamespace(report=recorder.report(), rows=dict(rows), first=digests[0])


def test_every_cube_comes_to_rest_in_the_basket_held_as_asked_and_nothing_else_touches(traced):
    assert traced.report.simulated_s / CYCLES <= 5.0
    for cycle in traced.report.cycles:
        assert (cycle.status, cycle.placed) == ("SUCCESS", True)
        assert cycle.unexpected_contacts == ()
        assert 0.95 * 50.0 <= cycle.grip_force_n <= 1.2 * 50.0
        assert 0.0 < cycle.max_tracking_error_rad <= 2e-3
        assert cycle.saturated_steps == 0


def test_the_reference_is_inside_the_limits_at_every_step(traced):
    trace = traced.rows  # the limits are those that the robot's maker publishes
    velocity = np.array([2.175] * 4 + [2.61] * 3)
    acceleration = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
    jerk = np.array([7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0])
    effort = np.array([87.0] * 4 + [12.0] * 3)
    a_little = 1 + 1e-6
    assert (np.abs(trace["v_ref"]) <= velocity * a_little).all()
    assert (np.abs(trace["a_ref"]) <= acceleration * a_little).all()
    assert (np.abs(np.diff(trace["a_ref"], axis=0)) / 1e-3 <= jerk * a_little).all()
    assert (np.abs(trace["tau"]) <= effort).all()


def test_the_trace_has_every_millisecond_and_the_reference_is_one_motion(traced):
    report, trace = traced.report, traced.rows
    assert np.diff(trace["t"]) == pytest.approx(1e-3, abs=1e-9)
    assert len(trace["t"]) == round(1e3 * report.simulated_s)
    assert trace["joints"].tolist() == [f"joint{i}" for i in range(1, 8)]
    # Integrating the reference's velocity gives its position: it never jumps.
    middle = 0.5 * (trace["v_ref"][1:] + trace["v_ref"][:-1]) * 1e-3
    assert np.diff(trace["q_ref"], axis=0) == pytest.approx(middle, abs=1e-6)


def test_the_same_tree_in_python_is_the_same_run(parts, traced):
    document = request_of("pick_place", parts).tree.path
    in_python = report_of(parts, f"{document.with_suffix('.py')}:pick_place")
    assert in_python.state_digest == traced.first


def test_the_same_seed_is_the_same_run_in_another_process(tmp_path, traced):
    report = tmp_path / "report.json"
    command = [sys.executable, "-m", "bt_manip", "run", "pick_place", "--report", str(report)]
    subprocess.run(command, check=True, capture_output=True)
    assert json.loads(report.read_text())["state_digest"] == traced.first


def test_another_controller_does_the_task_too(parts):
    report = report_of(parts, "pick_place", controller="gravity_compensated_pd")
    assert report.cycles[0].placed
