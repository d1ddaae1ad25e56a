"""A recorded run says what physics and tree did, and is the same run as an unrecorded one."""

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from bt_manip.behaviours import (
    Drop,
    Grasp,
    Hover,
    IsHolding,
    IsIn,
    IsOn,
    Lift,
    ObjectExists,
    OpenGripper,
    PlaceAt,
    Reach,
    RemoveObject,
    SpawnObject,
)
from bt_manip.bt import Action, Fallback, Node, ScriptCondition, Sequence, Status, Timeout
from bt_manip.cell import Cube, PhysicsDiverged
from bt_manip.record.report.recorder import Recorder
from bt_manip.record.report.run_report import GrippedObject, LeafTime, RunReport
from bt_manip.robots import panda
from bt_manip.runner import next_digest
from bt_manip.runner.observer import RunObserver
from bt_manip.spatial import pose

pytestmark = pytest.mark.usefixtures("shared_stations")


class Wait(Action):
    """Run for some ticks, and do something at the first one."""

    def __init__(self, ticks: int, then: Callable[..., None] | None = None) -> None:
        super().__init__("wait")
        self.ticks, self.then = ticks, then

    def setup(self, **station) -> None:
        self.station = station

    def initialise(self) -> None:
        self.left = self.ticks
        if self.then is not None:
            self.then(**self.station)

    def update(self) -> Status:
        self.left -= 1
        return Status.RUNNING if self.left > 0 else Status.SUCCESS


@pytest.fixture
def record(make_run) -> Callable[..., RunReport]:
    def run(root: Node, **request) -> RunReport:
        recorder = Recorder("test", request.get("seed", 0))
        make_run(root, **request).execute([recorder])
        return recorder.report()

    return run


def goal() -> Node:
    return IsIn(object="{cube}", container="basket")


def grasp(**ports) -> list[Node]:
    return [
        SpawnObject(object="{cube}", **ports),
        OpenGripper(),
        Reach(object="{cube}"),
        Grasp("grasp it", object="{cube}"),
    ]


def test_a_picked_cube_is_placed_in_phases_in_their_order_and_the_motion_is_measured(record):
    steps = [*grasp(), Lift(height=0.4), Drop(container="basket"), RemoveObject(object="{cube}")]
    report = record(Sequence("pick and place", steps), goal=goal())
    (picked,) = report.cycles
    assert report.simulated_s == pytest.approx(picked.duration_s)
    assert (report.status, picked.status) == ("SUCCESS", "SUCCESS")
    assert (picked.object, picked.placed) == ("cube", True)
    assert picked.objects == (GrippedObject("cube", True, "panda"),)
    phases = picked.phases
    assert [phase.behaviour for phase in phases] == [
        "SpawnObject", "OpenGripper", "Reach", "Grasp", "Lift", "Drop", "RemoveObject",
    ]  # fmt: skip
    assert phases[3].name == "grasp it"
    assert {phase.status for phase in phases} == {"SUCCESS"}
    for before, after in zip(phases, phases[1:], strict=False):
        assert after.start_s == pytest.approx(before.start_s + before.duration_s)
    assert 0.0 < picked.max_deflection_rad < 20e-3
    assert 0.5 < picked.limits.velocity <= 1.0 + 1e-6
    assert 0.5 < picked.limits.jerk <= 1.0 + 1e-6
    assert 0.1 < picked.max_tool_speed_m_s < 3.0
    peak = picked.tracking_peak
    phase = next(p for p in phases if p.name == peak.leaf)
    assert phase.start_s < peak.time_s <= phase.start_s + phase.duration_s
    assert peak.joint.startswith("joint") and 0.0 < peak.effort <= picked.limits.effort < 1.0


def cube_in_the_basket(cell, **_) -> None:
    cell.add(Cube(), pose(cell.pose("basket").translation + (0.0, 0.0, 0.05)), name="other")


def test_a_dropped_cube_is_not_placed_because_another_one_is_in_the_basket(record):
    dropped = Lift(height=0.05), Wait(60, cube_in_the_basket), OpenGripper(), Wait(50)
    report = record(Sequence(*grasp(), *dropped, RemoveObject(object="{cube}")), goal=goal())
    (cycle,) = report.cycles
    assert (cycle.object, cycle.placed, cycle.goal) == ("cube", False, False)
    assert cycle.goal_reason == "'cube' touches 'table'"
    assert (cycle.status, cycle.reason) == ("FAILURE", "goal not met: 'cube' touches 'table'")
    assert report.status == "FAILURE"


def test_an_object_is_placed_where_the_goal_wants_it(record):
    put = PlaceAt(object="{cube}", pose="0.35;0.1;1.015")
    root = Sequence("s", [*grasp(), put])
    (cycle,) = record(root, goal=IsOn(object="{cube}", support="table")).cycles
    assert (cycle.status, cycle.object, cycle.placed) == ("SUCCESS", "cube", True)


@pytest.mark.parametrize(
    ("goal", "met", "placed"),
    [
        ((), None, None),  # no condition names the cube
        (ObjectExists(object="basket"), True, None),
        (IsHolding(object="{cube}"), True, None),
        (goal(), False, False),
    ],
    ids=["none", "ObjectExists", "IsHolding", "IsIn"],
)
def test_a_cube_that_is_still_held_is_placed_nowhere(record, goal, met, placed):
    (cycle,) = record(Sequence("s", grasp()), goal=goal).cycles
    assert (cycle.goal, cycle.status) == (met, "FAILURE" if met is False else "SUCCESS")
    assert cycle.objects == (GrippedObject("cube", placed, "panda"),)
    assert (cycle.object, cycle.placed) == ("cube", placed)


def weaken(cell, **_) -> None:
    """Take 70 % of the force of the gripper."""
    for i in range(cell.model.nu):
        if "finger" in cell.model.actuator(i).name:
            cell.model.actuator_gainprm[i] *= 0.3


def test_a_weak_grip_that_carries_is_reported_as_the_behaviours_see_it(record):
    steps = grasp(region="0.3;0.3;0;0")
    steps = [steps[0], Wait(1, weaken), *steps[1:3], Fallback("grip", [steps[3], Wait(1)])]
    root = Sequence(*steps, Lift(height=0.2), Drop(container="basket"))
    (cycle,) = record(root, goal=goal()).cycles
    assert "no steady grip" in next(p for p in cycle.phases if p.behaviour == "Grasp").reason
    assert (cycle.status, cycle.object, cycle.placed) == ("SUCCESS", "cube", True)
    assert cycle.grip_force_n == pytest.approx(0.3 * 60.0, abs=5.0)


def test_a_grip_of_fingers_that_open_wider_than_described_is_reported_as_the_physics_shows(record):
    forces: list[float] = []

    def measure(cell, **_) -> None:
        pairs = np.array(cell.data.contact.geom).reshape(-1, 2)
        for finger in ("left", "right"):
            pad, force = cell.model.geom(f"panda/{finger}_finger_pad").id, np.zeros(6)
            forces.append(0.0)
            for i in np.flatnonzero((pairs == pad).any(axis=1)):
                mujoco.mj_contactForce(cell.model, cell.data, int(i), force)
                forces[-1] += force[0]

    described = panda()
    narrow = {**described.gripper.parameters, "open_width": 0.055}  # they open by 80 mm
    gripper = replace(described.gripper, parameters=narrow)
    wider = replace(described, gripper=gripper)
    steps = [*grasp(region="0.3;0.3;0;0"), Wait(1, measure), Drop(container="basket")]
    (cycle,) = record(Sequence(*steps), goal=goal(), robot=wider).cycles
    assert (cycle.status, cycle.object, cycle.placed) == ("SUCCESS", "cube", True)
    assert len(forces) == 2 and cycle.grip_force_n == pytest.approx(min(forces), abs=3.0)


@pytest.mark.parametrize(
    ("goal", "judge"),
    [
        ((), "tree"),
        (ScriptCondition(code="1==1"), "tree"),
        (ObjectExists(object="table"), "physics"),
    ],
)
def test_the_report_says_who_judged(record, goal, judge):
    (cycle,) = record(Wait(2), goal=goal).cycles
    assert (cycle.status, cycle.judged_by) == ("SUCCESS", judge)
    assert (cycle.object, cycle.placed, cycle.objects) == (None, None, ())  # nothing was gripped
    assert cycle.leaf_times == {}


def test_a_failed_tree_keeps_its_reason_beside_that_of_the_goal(record):
    (cycle,) = record(Hover("look", object="nothing"), goal=goal()).cycles
    assert cycle.status == "FAILURE" and cycle.goal is False
    assert cycle.reason.startswith("look") and "nothing" in cycle.reason
    assert cycle.phases[0].reason and cycle.phases[0].reason in cycle.reason
    assert "the blackboard entry 'cube' does not exist" in cycle.goal_reason


class Policy(Wait):
    """A leaf that fails at its last tick."""

    reports_time = True

    def update(self) -> Status:
        status = super().update()
        return self.fail("does not fit") if status is Status.SUCCESS else status


@pytest.mark.parametrize(
    ("first", "expected"),
    [
        (Policy(31), LeafTime(0.5, ("does not fit",))),
        (Policy(1), LeafTime(0.0, ("does not fit",))),
        (Fallback("never", [Wait(31), Policy(5)]), LeafTime(0.0, ("it was not ticked",))),
    ],
)
def test_leaves_that_others_replace_are_reported_with_their_share(record, first, expected):
    (cycle,) = record(Sequence("s", [Fallback("or", [first, Wait(1)]), Wait(30)])).cycles
    assert cycle.status == "SUCCESS" and list(cycle.leaf_times) == ["Policy"]
    found = cycle.leaf_times["Policy"]
    assert found.reasons == expected.reasons
    assert found.share == pytest.approx(expected.share, abs=0.02)


def test_what_touches_the_arm_is_unexpected_and_named(record):
    def on_the_forearm(cell, **_) -> None:
        place = cell.data.body("panda/link4").xpos + (0.0, 0.0, 0.1)
        cell.add(Cube(), pose(place), overlap=np.inf)

    (cycle,) = record(Wait(40, on_the_forearm)).cycles
    assert (pairs := cycle.unexpected_contacts)
    assert all("cube" in pair and any(name.startswith("panda/") for name in pair) for pair in pairs)


def test_a_run_whose_state_diverges_in_the_grip_ends_with_its_reason(make_run):
    def diverge(cell, **_) -> None:
        cell.data.qvel[:] = np.nan

    recorder = Recorder("test", 0)
    with pytest.raises(PhysicsDiverged):
        make_run(Sequence("s", [*grasp(), Wait(9, diverge)]), goal=goal()).execute([recorder])
    (cycle,) = recorder.report("ERROR", "MuJoCo warned").cycles
    assert (cycle.status, cycle.reason) == ("ERROR", "MuJoCo warned")
    assert (cycle.object, cycle.placed) == ("cube", False)


def test_a_run_that_never_began_has_a_report():
    report = Recorder("test", 3).report("INTERRUPTED")
    assert (report.cycles, report.simulated_s, report.seed) == ((), 0.0, 3)


def test_recording_leaves_the_run_as_it_is_and_another_seed_does_not(make_run, record):
    class DigestOnly(RunObserver):
        digest = b""

        def after_tick(self) -> None:
            self.digest = next_digest(self.digest, cell.state_bytes(), run.tree.statuses())

    def hover() -> Node:
        return Sequence(SpawnObject(object="{c}"), Hover(object="{c}"), OpenGripper())

    bare, run = DigestOnly(), make_run(hover(), seed=5)
    cell = run.station.cell
    run.execute([bare])
    report = record(hover(), seed=5)
    assert report.state_digest == bare.digest.hex() != record(hover(), seed=6).state_digest


def test_a_halted_leaf_is_a_phase_too(record):
    report = record(Timeout("no longer", Wait(100), msec=50))
    (phase,) = report.cycles[0].phases
    assert phase.status == "HALTED"
    assert phase.duration_s == pytest.approx(0.05)
    assert report.status == "FAILURE"
