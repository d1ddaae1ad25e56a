"""What a cycle leaves behind, and what the next one finds."""

import pytest

from bt_manip.record import Recorder
from bt_manip.runner import Reloader, RunRequest, TreeSource, known_behaviours, prepare

from .conftest import Snapshots, continued
from .test_reloading import Editor

ROOT = """<Sequence>
  <SpawnObject model="cube" object="{cube}"/>
  <CloseGripper/>
  <Sleep msec="20"/>
</Sequence>"""


class Begins(Snapshots):
    """Notes time, objects and opening of the gripper as each cycle begins, and snapshots."""

    def __init__(self):
        self.found, self.places = [], set()

    def cycle_started(self, cycle):
        station = self.run.station
        width = round(station.gripper.width, 4)
        self.found.append((station.cell.time, tuple(station.cell.entities), width))

    def cycle_ended(self, status, reason):
        self.places.add(tuple(self.run.station.cell.pose("cube").translation[:2]))


@pytest.fixture
def leave(task, parts):
    """Prepare runs of a tree that leaves a cube on the table and the gripper closed."""

    def make(attributes="", cycles=3):
        path = task(ROOT, attributes)
        return prepare(RunRequest(TreeSource("leave", "xml", path=path), cycles=cycles), parts)

    return make


def test_each_cycle_begins_in_the_cell_as_it_was_at_the_start_while_time_goes_on(leave):
    begins = Begins()
    leave().execute([begins])
    times, things, widths = zip(*begins.found, strict=True)
    assert 0.0 == times[0] < times[1] < times[2]
    assert len(set(things)) == len(set(widths)) == 1
    assert not any("cube" in name for name in things[0]) and widths[0] > 0.07
    assert len(begins.places) == 3  # each cycle draws samples of its own


def test_a_tree_that_continues_finds_what_the_cycle_before_has_left(leave):
    begins = Begins()
    run = leave('_continues="true"')
    run.execute([begins])
    _, things, widths = zip(*begins.found, strict=True)
    assert [sum("cube" in name for name in found) for found in things] == [0, 1, 2]
    assert widths[0] > 0.07 > widths[1]


def test_a_run_that_is_resumed_puts_the_cell_back_as_the_whole_run_does(leave):
    whole, begins, recorder = leave(), Begins(), Recorder("leave", 0)
    whole.execute([begins, recorder])
    last = next(i for i, one in enumerate(begins.taken) if one["run"]["cycle"] == 1)
    for tick in (last, last + 2):  # the last one of a cycle, and one in the middle of the next
        assert continued(leave(), begins.taken[tick]) == recorder.report().state_digest


def test_an_edited_tree_begins_in_the_cell_as_it_was_at_the_start(leave, parts):
    run, told = leave(cycles=1), []
    path = run.request.tree.path
    edited = path.read_text().replace("<CloseGripper/>", "")
    reloader = Reloader(run.request.tree, known_behaviours(parts), told.append)
    run.execute([Editor(path, 5, edited), reloader])
    assert "begins anew" in told[0]
    assert [name for name in run.station.cell.entities if "cube" in name] == ["cube"]
    assert run.station.gripper.width > 0.07
