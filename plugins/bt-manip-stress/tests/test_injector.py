"""Faults begin at their node and end with their time or their cycle."""

from dataclasses import dataclass

import pytest

from bt_manip.bt import Sequence, Sleep, Tree
from bt_manip.exceptions import NodeError
from bt_manip.registry import Registry
from bt_manip.runner import Run, RunRequest, TreeSource
from bt_manip_stress import Fault, FaultError, FaultInjector, parse_fault

LOG = []


@dataclass
class Noted(Fault):
    """Writes down when it begins and ends [ms]."""

    def begin(self):
        self.note("begins")
        self.at_end(self.note, "ends")

    def note(self, what):
        LOG.append((what, round(1000 * (self.context.cell.time - BEGIN[0]))))


@dataclass
class Impossible(Fault):
    """Cannot happen."""

    def begin(self):
        raise FaultError("nothing to break")


BEGIN = [0.0]


@pytest.fixture
def run(station, parts):
    """Run two Sleeps of 50 ms with faults; give the reasons why some did not happen."""
    faults = Registry("fault")
    faults.add("noted", Noted, "test")
    faults.add("impossible", Impossible, "test")
    for name in ("exception", "tick_delay"):
        faults.add(name, parts.of("faults").get(name), "test")
    LOG.clear()

    def run(*texts, cycles=1):
        tree = Tree(
            Sequence("all", [Sleep("first", msec=50), Sleep("second", msec=50)]),
            clock=station.clock,
        )
        tree.setup(**station.infrastructure)
        request = RunRequest(TreeSource("sleeps", "python"), cycles=cycles)
        planned, problems = [parse_fault(text, faults) for text in texts], []
        injector = FaultInjector(planned, faults, warn=problems.append)
        BEGIN[0] = station.cell.time
        Run(request, tree, station).execute([injector])
        return problems

    return run


def test_a_fault_begins_with_its_node_and_ends_with_its_time(run):
    assert not run("noted at=second duration=0.02")
    assert LOG == [("begins", 60), ("ends", 80)]


def test_a_fault_begins_some_time_after_its_node_and_ends_with_its_cycle(run):
    run("noted at=first after=0.03")
    assert LOG == [("begins", 30), ("ends", 110)]


def test_a_fault_happens_in_each_cycle_or_in_one(run):
    run("noted at=first", cycles=3)
    assert [what for what, _ in LOG] == ["begins", "ends"] * 3
    LOG.clear()
    run("noted at=first cycle=2", cycles=3)
    assert [what for what, _ in LOG] == ["begins", "ends"]


def test_a_fault_whose_node_ended_too_early_or_that_cannot_happen_is_reported(run):
    assert run("noted at=second after=1") == [
        "fault 'noted at=second after=1' did not happen in cycle 1: 'second' ended too early"
    ]
    (problem,) = run("impossible at=first")
    assert "in cycle 1: nothing to break" in problem


def test_a_behaviour_raises_and_the_faults_end_with_the_run(run):
    with pytest.raises(NodeError, match="first .Sleep.: injected exception"):
        run("noted at=first", "exception at=first")
    assert LOG[0] == ("begins", 10) and LOG[1][0] == "ends"


def test_ticks_are_delayed_while_the_physics_goes_on_and_in_the_next_run_are_as_before(run):
    run("noted at=first", "tick_delay at=first duration=0.3")
    assert LOG == [("begins", 10), ("ends", 370)]
    LOG.clear()
    run("noted at=second")
    assert LOG == [("begins", 60), ("ends", 110)]
