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


def run(parts, path, tree, *faults, cycles=1, scene=None):
    modifiers = {"fault": faults} if faults else {}
    request = request_of(tree, parts, cycles=cycles, scene=scene, modifiers=modifiers)
    recorder = Recorder(tree, 0)
    prepare(request, parts).execute([recorder, McapRecorder(path)])
    return recorder.report().cycles, RecordedRun(Recording(path)).cycles


def check_figures(reported, recorded):
    for live, read in zip(reported, recorded, strict=True):
        for name in figures(live) - {"robots"}:
            assert getattr(read, name) == getattr(live, name), name
        assert read.phases and read.tracking_peak and read.max_tool_speed_m_s > 0.0


@pytest.mark.parametrize(
    ("faults", "statuses"),
    [
        (["vanish at=Reach cycle=1"], ["FAILURE", "SUCCESS"]),
        (["push at=Lift force=100 duration=2", "stuck_finger at=Grasp"], ["SUCCESS"]),
    ],
)
def test_a_recording_has_the_figures_of_the_report(parts, tmp_path, faults, statuses):
    path = tmp_path / "run.mcap"
    reported, recorded = run(parts, path, "pick_place", *faults, cycles=len(statuses))
    assert [cycle.status for cycle in reported] == statuses
    check_figures(reported, recorded)
    for live, read in zip(reported, recorded, strict=True):
        (robot,) = read.robots.values()
        assert robot.picked == tuple(one.name for one in live.objects)


TWO_ARMS = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"><Sequence>
    <SpawnObject region="-0.25;-0.15;-0.3;-0.1" object="{a}"/>
    <SpawnObject region="0.15;0.25;0.1;0.3" object="{b}"/>
    <Parallel success_count="-1" failure_count="1">
      <SubTree ID="Pick" name="left" robot="left" object="{a}"/>
      <SubTree ID="Pick" name="right" robot="right" object="{b}"/>
    </Parallel>
  </Sequence></BehaviorTree>
  <BehaviorTree ID="Pick"><Sequence>
    <Hover object="{object}" height="0.25"/><Reach object="{object}"/>
    <Grasp object="{object}" force="50"/><Lift height="0.1"/>
  </Sequence></BehaviorTree>
</root>
"""


def test_a_recording_of_two_arms_has_the_figures_of_each(parts, tmp_path):
    tree = tmp_path / "two.xml"
    tree.write_text(TWO_ARMS)
    reported, recorded = run(parts, tmp_path / "run.mcap", str(tree), scene="two_arms")
    check_figures(reported, recorded)
    (live,), (read,) = reported, recorded
    assert live.status == "SUCCESS" and read.robots == live.robots
    picked = {name: len(robot.picked) for name, robot in read.robots.items()}
    assert picked == {"left": 1, "right": 1}


def test_an_interrupted_run_has_the_figures_of_its_report(parts, tmp_path):
    recorder, run = Recorder("pick_place", 0), prepare(request_of("pick_place", parts), parts)
    recorders = [recorder, McapRecorder(tmp_path / "run.mcap")]
    run.execute(recorders, stop=lambda: run.station.cell.time > 1.0)
    (live,) = recorder.report("INTERRUPTED").cycles
    (read,) = RecordedRun(Recording(tmp_path / "run.mcap")).cycles
    assert (live.status, read.status) == ("INTERRUPTED", "RUNNING")
    assert live.phases[-1].status == "HALTED" and live.phases[-1].reason
    for name in figures(live) - {"robots", "status"}:
        assert getattr(read, name) == getattr(live, name), name
