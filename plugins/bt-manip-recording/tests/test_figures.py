"""The figures of a run are the same from its events while it goes on and from its recording."""

from dataclasses import fields

import pytest

from bt_manip.record import Recorder
from bt_manip.runner import prepare, request_of
from bt_manip_recording import McapRecorder, RecordedRun, Recording

JUDGED = {
    "goal", "goal_reason", "judged_by", "object", "placed", "objects", "unexpected_contacts",
    "randomized", "leaf_times", "drawn", "retries", "rescues", "results",
}  # fmt: skip
"""Fields of a report that only the run knows: the physics or the nodes give them."""


def figures(cycle):
    """Give the names of the figures that the report and the recording of a cycle have."""
    return {field.name for field in fields(cycle)} - JUDGED


def run(parts, path, tree, *faults, cycles=1, seed=0):
    modifiers = {"fault": faults} if faults else {}
    request = request_of(tree, parts, cycles=cycles, seed=seed, modifiers=modifiers)
    recorder = Recorder(tree, seed)
    prepare(request, parts).execute([recorder, McapRecorder(path)])
    return recorder.report().cycles, RecordedRun(Recording(path)).cycles


@pytest.mark.parametrize(
    ("tree", "faults", "cycles"),
    [
        ("pick_place", [], 2),
        ("pick_place", ["vanish at=Reach cycle=1"], 2),
        ("pick_place", ["push at=Lift force=100 duration=2", "stuck_finger at=Grasp"], 1),
        ("two_arms", [], 1),
    ],
)
def test_a_recording_has_the_figures_of_the_report(parts, tmp_path, tree, faults, cycles):
    reported, recorded = run(parts, tmp_path / "run.mcap", tree, *faults, cycles=cycles)
    assert len(reported) == len(recorded) == cycles
    statuses = [cycle.status for cycle in reported]
    assert statuses == ["FAILURE" if "vanish" in str(faults) and not i else "SUCCESS"
                        for i in range(cycles)]  # fmt: skip
    for live, read in zip(reported, recorded, strict=True):
        for name in figures(live) - {"robots"}:
            assert getattr(read, name) == getattr(live, name), name
        assert read.phases and read.tracking_peak and read.max_tool_speed_m_s > 0.0
        if live.robots:
            assert read.robots == live.robots
        else:
            (robot,) = read.robots.values()
            assert robot.picked == tuple(one.name for one in live.objects)


def test_an_interrupted_run_has_the_figures_of_its_report(parts, tmp_path):
    recorder, run = Recorder("pick_place", 0), prepare(request_of("pick_place", parts), parts)
    recorders = [recorder, McapRecorder(tmp_path / "run.mcap")]
    run.execute(recorders, stop=lambda: run.station.cell.time > 1.0)
    (live,), (read,) = (
        recorder.report("INTERRUPTED").cycles,
        RecordedRun(Recording(tmp_path / "run.mcap")).cycles,
    )
    assert (live.status, read.status) == ("INTERRUPTED", "RUNNING")
    assert live.phases[-1].status == "HALTED" and live.phases[-1].reason
    for name in figures(live) - {"robots", "status"}:
        assert getattr(read, name) == getattr(live, name), name
