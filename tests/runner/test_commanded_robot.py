"""A robot's controllers are switched by trees, and come back after each cycle."""

from itertools import groupby

import pytest

from bt_manip import build_station
from bt_manip.behaviours import SwitchController
from bt_manip.exceptions import NodeError
from bt_manip.record import Recorder
from bt_manip.runner import RunObserver, RunRequest, find_tree, prepare

from .conftest import Snapshots, continued

ROOT = """<Sequence>
  <Approach distance="0.1"/>
  <SwitchController controller="gravity_compensated_pd"/>
  <Lift height="0.1" speed="0.5"/>
  <SwitchController/>
  <Approach distance="0.1"/>
  <SwitchController controller="gravity_compensated_pd"/>
  {last}
</Sequence>"""


def run_of(parts, task, last="<MoveHome/>", **request):
    tree = task(ROOT.format(last=last))
    return prepare(RunRequest(find_tree(str(tree), {}), **request), parts)


def test_a_run_continues_bit_for_bit_from_a_snapshot_during_a_transfer(parts, task):
    recorder, snapshots = Recorder("", 0), Snapshots()
    run_of(parts, task).execute([recorder, snapshots])
    (cycle,) = recorder.report().cycles  # the figures are those of the active controller
    assert cycle.saturated_steps == 0
    assert cycle.limits.effort < 1.0
    stations = [one["run"]["station"] for one in snapshots.taken]
    controllers = [one["robots"]["panda"]["controllers"] for one in stations]
    active = [one["active"] for one in controllers]
    own, other = "computed_torque", "gravity_compensated_pd"
    assert [name for name, _ in groupby(active)] == [own, other, own, other, own]
    switched = active.index(other)
    assert controllers[switched + 4]["controller"]["transfer_steps"] == 50
    for tick in (switched + 4, -3):
        digest = continued(run_of(parts, task), snapshots.taken[tick])
        assert digest == recorder.report().state_digest


def test_each_cycle_begins_with_the_robots_own_controller(parts, task):
    run = run_of(parts, task, "<AlwaysFailure/>", cycles=2)
    began, observer = [], RunObserver()
    observer.cycle_started = lambda cycle: began.append(run.station.controllers.active)
    run.execute([observer])
    assert began == ["computed_torque"] * 2
    assert run.station.controllers.active == "computed_torque"


def test_an_unknown_controller_is_found_before_anything_moves(parts):
    station = build_station(parts)
    with pytest.raises(NodeError, match="did you mean 'computed_torque'"):
        station.run(SwitchController(controller="computed_torqe"))
    assert station.cell.time == 0.0
