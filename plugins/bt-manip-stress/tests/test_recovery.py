"""Trees recover from faults, or name the cause, and leave nothing behind where they cannot."""

import re

import pytest

from bt_manip.record import Recorder, RunReport
from bt_manip.registry import Parts
from bt_manip.runner import RunObserver, prepare, request_of

pytestmark = pytest.mark.usefixtures("shared_stations")


class Leftovers(RunObserver):
    """Lists the free objects in the cell after each cycle."""

    def run_started(self, run):
        self.cell, self.after = run.station.cell, []

    def cycle_ended(self, status, reason):
        self.after.append([name for name in self.cell.objects if self.cell.is_free(name)])


@pytest.fixture
def disturbed(parts: Parts):
    def run(tree: str, *faults: str, cycles: int = 1) -> RunReport:
        request = request_of(tree, parts, cycles=cycles, modifiers={"fault": faults})
        recorder, leftovers, problems = Recorder(tree, 0), Leftovers(), []
        prepare(request, parts, problems.append).execute([recorder, leftovers])
        assert not problems
        assert leftovers.after == [[]] * cycles
        return recorder.report()

    return run


@pytest.mark.parametrize(
    "fault",
    [
        "move at=Hover after=0.3",
        "knock at=Lift after=0.3",
        "obstacle at=Drop after=0.1",
        "stuck_finger at=Grasp duration=1",
    ],
)  # in other phases: test_tree_stress.py
def test_the_cube_is_placed_in_spite_of_a_fault(disturbed, fault):
    report = disturbed("pick_place", f"{fault} cycle=1")
    assert [(cycle.status, cycle.placed) for cycle in report.cycles] == [("SUCCESS", True)]


def test_the_arm_moves_again_when_the_push_is_over(disturbed):
    cycle = disturbed("pick_place", "push at=Lift force=100 duration=2").cycles[0]
    phases = {phase.behaviour: phase for phase in cycle.phases}
    assert phases["BackOff"].start_s > phases["Lift"].start_s + 2.0
    assert [phase.status for phase in cycle.phases if phase.behaviour == "BackOff"] == ["SUCCESS"]


def test_an_object_that_is_still_held_is_not_picked_again(disturbed):
    fault = "push at=Drop after=0.2 force=60 duration=0.5 cycle=1"
    cycle = disturbed("pick_place", fault).cycles[0]
    names = [phase.behaviour for phase in cycle.phases]
    assert names.count("Drop") == 2 and names.count("Grasp") == 1
    assert (cycle.status, cycle.placed) == ("SUCCESS", True)


def test_a_failed_cycle_leaves_no_object_even_if_the_arm_cannot_move(disturbed):
    faults = "vanish at=Reach cycle=1", "stuck_joint at=Drop joint=2 duration=60 cycle=2"
    report = disturbed("pick_place", *faults, cycles=3)
    assert [cycle.status for cycle in report.cycles] == ["FAILURE", "FAILURE", "SUCCESS"]
    assert "no 'cube'" in report.cycles[0].reason
    ended = {phase.behaviour: phase.status for phase in report.cycles[1].phases}
    assert (ended["MoveHome"], ended["RemoveObject"]) == ("FAILURE", "SUCCESS")


class Faults(RunObserver):
    """Keeps the faults of the arm."""

    def run_started(self, run):
        self.arm, self.found = run.station.arm, []

    def after_tick(self):
        if self.arm.fault and self.arm.fault not in self.found:
            self.found.append(self.arm.fault)


@pytest.mark.parametrize(("node", "mass"), [("Grasp", 3.2), ("Drop", 1.0)])
def test_payload_that_is_too_heavy_is_named_with_its_mass(parts, node, mass):
    modifiers = {"fault": (f"heavy at={node} mass={mass}",)}
    faults = Faults()
    run = prepare(request_of("pick_place", parts, modifiers=modifiers), parts)
    run.execute([faults], stop=lambda: bool(faults.found))
    found = re.match(r"the payload weighs about (\S+) kg, 0.057 kg were assumed", faults.found[0])
    assert found, faults.found
    assert float(found.group(1)) == pytest.approx(mass, rel=0.15)
