"""The table of cycles fits any terminal and cuts nothing; a sentence says how the run ended."""

import io
import re
from dataclasses import replace

import pytest
from rich.console import Console

from bt_manip.cli.cycle_table import print_cycles, summary
from bt_manip.record import CycleReport, GrippedObject, LeafTime, RunReport, TrackingPeak


def cycle(**facts) -> CycleReport:
    facts = {"status": "SUCCESS", "object": "cube", "goal": True, "duration_s": 12.34, **facts}
    objects = (GrippedObject(facts["object"], None, "panda"),)
    return CycleReport(**facts, objects=objects)


def report(*cycles: CycleReport, status: str = "SUCCESS", simulated_s: float = 24.7) -> RunReport:
    return RunReport(
        tree="t", seed=0, status=status, cycles=cycles, state_digest="", versions={},
        simulated_s=simulated_s, real_time_factor=4.0,
    )  # fmt: skip


def printed(run: RunReport, width: int, terminal: bool = True) -> list[str]:
    out = io.StringIO()
    print_cycles(Console(file=out, width=width, force_terminal=terminal, no_color=True), run)
    return re.sub(r"\x1b\[[0-9;]*m", "", out.getvalue()).splitlines()


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize("width", [50, 60, 80])
def test_every_line_fits_and_nothing_is_cut(width, terminal):
    failed = cycle(status="FAILURE", goal=False, reason="pick/Grasp: " + "too heavy " * 20)
    text = printed(report(cycle(), failed), width, terminal)
    assert max(map(len, text)) <= width
    whole = "\n".join(text)
    assert "…" not in whole
    for word in ("cycle", "status", "object", "goal", "met", "time", "SUCCESS", "FAILURE", "cube"):
        assert word in whole


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize("width", [30, 40])
def test_where_the_results_do_not_fit_a_row_is_a_line(width, terminal):
    counted = cycle(results={"left": 2, "right_by_far": 1.5, "thrown_away": None})
    text = printed(report(counted), width, terminal)
    assert max(map(len, text)) <= width
    assert "…" not in "".join(text)
    whole = " ".join(" ".join(text).split())
    assert "cycle 1: status SUCCESS, object cube, goal met yes, time [s] 12.34, left 2" in whole
    assert "right_by_far 1.5, thrown_away -" in whole


def test_at_80_columns_all_figures_are_shown_and_at_60_the_main_ones():
    wide, narrow = (" ".join(printed(report(cycle()), width)) for width in (80, 60))
    assert all(unit in wide for unit in ("[s]", "[N]", "[mrad]", "[%]"))
    assert "[s]" in narrow and "[%]" not in narrow


def test_leaves_that_a_fallback_replaced_are_named():
    used = cycle(leaf_times={"RunPolicy": LeafTime(0.0, ("does not fit",))})
    text = " ".join(printed(report(used), 80))
    assert "RunPolicy ran in 0 of 1 cycles, for 0.0% of the time: 1 x does not fit" in text


def test_a_long_name_is_wrapped():
    text = printed(report(cycle(object="fuel_openrobotics_wood_cube_" + "x" * 60)), 60)
    assert max(map(len, text)) <= 60
    assert "".join(text).count("x") == 60 + "".join(text).count("x real")


@pytest.mark.parametrize(
    ("run", "says"),
    [
        (report(cycle(), simulated_s=12.3),
         "1 of 1 cycles succeeded, goal met in 1; 12.3 s simulated at 4.0 x real time."),
        (report(cycle(), cycle(status="FAILURE", goal=False), status="FAILURE"),
         "1 of 2 cycles succeeded, goal met in 1, 12.34 s each; 24.7 s simulated at 4.0 x real "
         "time."),
        (report(cycle(status="INTERRUPTED"), status="INTERRUPTED", simulated_s=1.5),
         "The run was interrupted before a cycle was complete, after 1.5 s simulated."),
        (report(cycle(), cycle(status="INTERRUPTED"), status="INTERRUPTED"),
         "1 of 1 cycles succeeded, goal met in 1; then the run was interrupted; 24.7 s simulated "
         "at 4.0 x real time."),
        (report(cycle(status="ERROR"), status="ERROR", simulated_s=0.0),
         "The run ended by a fault before a cycle was complete, after 0.0 s simulated."),
    ],
)  # fmt: skip
def test_a_sentence_says_how_the_run_ended(run, says):
    assert summary(run) == says


def words(run: RunReport) -> str:
    return " ".join(" ".join(printed(run, 80)).split())


PEAK = TrackingPeak("elbow", "Lift", 3.125, 0.4)


def test_large_deflections_and_tracking_errors_are_reported():
    exact = cycle(max_tracking_error_rad=1.9e-3, tracking_peak=PEAK, max_deflection_rad=0.019)
    yielding = cycle(max_deflection_rad=0.0304)
    assert "mrad" not in words(report(exact)).partition("1 SUCCESS")[2]
    assert "joints gave way by 30 mrad" in words(report(exact, yielding))


@pytest.mark.parametrize(
    ("preceding", "cause"),
    [
        ({"effort": 1.0, "after_contact_s": 0.02}, "when a motor was at its effort limit."),
        ({"after_contact_s": 0.02}, "20 ms after a contact ended."),
        ({}, "without contact and with motors at up to 40 % of their limits: friction, little"),
    ],
)
def test_a_large_tracking_error_is_reported_with_its_place_and_cause(preceding, cause):
    worst = cycle(max_tracking_error_rad=4.52e-3, tracking_peak=replace(PEAK, **preceding))
    place = "joints were up to 4.5 mrad from their reference: 'elbow' in Lift, 3.12 s into cycle 2"
    assert f"{place}, {cause}" in words(report(cycle(), worst))
