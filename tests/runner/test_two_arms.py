"""Two robots at one table: both pick, neither touches the other."""

from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from bt_manip.cli.cycle_table import print_cycles
from bt_manip.record.report.run_report import RunReport
from bt_manip.runner import STEP_FIELDS, RunObserver
from bt_manip_recording import Trace

from .conftest import report_of


def run(parts, cycles: int, *observers: RunObserver) -> RunReport:
    return report_of(parts, "two_arms", *observers, cycles=cycles, seed=1)


@pytest.fixture(scope="module")
def traced(parts, tmp_path_factory) -> tuple[RunReport, dict[str, np.ndarray]]:
    path = tmp_path_factory.mktemp("run") / "trace.npz"
    report = run(parts, 1, Trace(path))
    with np.load(path) as rows:
        return report, dict(rows)


def check(report: RunReport) -> None:
    for cycle in report.cycles:
        assert (cycle.status, cycle.reason, cycle.placed) == ("SUCCESS", "", True)
        assert cycle.unexpected_contacts == ()
        picked = {name: robot.picked for name, robot in cycle.robots.items()}
        assert {name: len(objects) for name, objects in picked.items()} == {"left": 2, "right": 2}
        assert len({*picked["left"], *picked["right"]}) == 4
        assert cycle.saturated_steps == 0


def test_both_pick_two_cubes_neither_touches_the_other_and_the_report_says_so(traced):
    check(traced[0])
    (cycle,) = traced[0].cycles
    for robot in cycle.robots.values():
        assert 0.95 * 50.0 <= robot.grip_force_n <= 1.2 * 50.0
        assert 0.0 < robot.max_tracking_error_rad <= 2e-3
    worst = max(robot.max_tool_speed_m_s for robot in cycle.robots.values())
    assert cycle.max_tool_speed_m_s == worst > 0.2
    shown = StringIO()
    print_cycles(Console(file=shown, width=120), traced[0])
    assert "left 2, right 2" in shown.getvalue()


def test_the_trace_has_the_course_of_each_of_them_and_both_move_at_the_same_time(traced):
    _, trace = traced
    columns = (*STEP_FIELDS, "joints")
    names = [f"{robot}/{column}" for robot in ("left", "right") for column in columns]
    assert sorted(trace) == sorted([*names, "t"])
    for robot in ("left", "right"):
        assert trace[f"{robot}/q"].shape == (len(trace["t"]), 7)
        assert np.abs(np.diff(trace[f"{robot}/q"], axis=0)).max() < 3e-3
    assert np.abs(trace["left/q"] - trace["right/q"]).max() > 0.5
    moves = [np.abs(trace[f"{robot}/v_ref"]).max(axis=1) > 0.0 for robot in ("left", "right")]
    assert (moves[0] & moves[1]).mean() > 0.3


@pytest.mark.soak
def test_fifty_of_fifty_cycles_succeed(parts):
    check(run(parts, 50))
