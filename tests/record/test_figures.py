"""Extremes of a motion against numbers that a pencil gives, and figures of a cycle."""

from dataclasses import astuple, fields
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.record.figures import (
    CycleFigures,
    MotionStatistics,
    RobotFigures,
    RobotState,
    RunFigures,
    combined,
)
from bt_manip.record.report.run_report import CycleLimitUse, Phase, RobotCycle, TrackingPeak
from bt_manip.robots import JointLimits
from bt_manip.runner import RunEvent, StepBlock

DT = 1e-3
LIMITS = JointLimits(
    lower=np.array([-1.0, 0.0]),
    upper=np.array([1.0, 4.0]),
    velocity=np.array([2.0, 4.0]),
    acceleration=np.array([10.0, 20.0]),
    jerk=np.array([1000.0, 2000.0]),
    effort=np.array([50.0, 100.0]),
)


def touches(*free: bool) -> list[SimpleNamespace]:
    return [SimpleNamespace(free=one) for one in free]


def rows(n: int, **changes: object) -> StepBlock:
    """Give n steps at rest in the middle of the range, but for some columns."""
    middle = np.tile([0.0, 2.0], (n, 1))
    still = np.zeros((n, 2))
    steps = StepBlock(
        t=np.arange(n) * DT, q=middle, v=still, q_ref=middle, v_ref=still, a_ref=still, tau=still,
        tool=np.zeros((n, 3)), touches=touches(*[True] * n),
    )  # fmt: skip
    return steps._replace(**changes)


@pytest.fixture
def statistics() -> MotionStatistics:
    return MotionStatistics(LIMITS, DT)


def column(*values: tuple[float, float]) -> np.ndarray:
    return np.array(values, dtype=float)


def test_each_fraction_is_that_of_the_joint_that_uses_most_and_nothing_is_used_at_rest(statistics):
    statistics.update(rows(3))
    assert astuple(statistics.limit_use) == (0.0,) * 5
    assert (statistics.tracking_error, statistics.deflection) == (None, 0.0)
    assert (statistics.torque_rate, statistics.tool_speed) == (0.0, 0.0)
    statistics.update(
        rows(
            2,
            q_ref=column((0.5, 2.0), (0.0, 3.8)),  # a half; 0.9 of the way from 2 to 4
            v_ref=column((-1.0, 0.0), (0.0, 1.0)),
            tau=column((0.0, 25.0), (-5.0, 0.0)),
        )
    )
    use = statistics.limit_use
    assert use.position == pytest.approx(0.9)
    assert use.velocity == pytest.approx(0.5)
    assert use.effort == pytest.approx(0.25)


def test_rates_are_differences_between_steps_also_of_two_blocks(statistics):
    tool = np.outer([0.0, 2.0, 4.0, 6.0], [1e-3, -2e-3, 2e-3])  # 6 mm a step
    a_ref = column((0.0, 0.0), (0.5, -1.5), (1.0, -3.0), (1.5, -4.5))
    for part in (slice(0, 3), slice(3, 4)):
        block = rows(len(a_ref[part]), a_ref=a_ref[part], tau=a_ref[part], tool=tool[part])
        statistics.update(block)
    # joint 0: 0.5 / 1 ms = 500 of 1000; joint 1: 1.5 / 1 ms = 1500 of 2000.
    assert statistics.limit_use.jerk == pytest.approx(0.75)
    assert statistics.limit_use.acceleration == pytest.approx(0.225)
    assert statistics.torque_rate == pytest.approx(1500.0)
    assert statistics.tool_speed == pytest.approx(6.0)


def test_differences_reach_across_blocks_and_cycles_whose_figures_begin_with_nothing(statistics):
    statistics.update(rows(1, tau=column((60.0, 0.0)), a_ref=column((5.0, 0.0))))
    assert statistics.limit_use.effort == pytest.approx(1.2)
    assert statistics.torque_rate == statistics.limit_use.jerk == 0.0  # of the first step
    statistics.update(rows(1))
    statistics.begin()
    assert statistics.limit_use.effort == statistics.torque_rate == 0.0
    jumped = np.tile([3.0, 0.0], (2, 1))
    statistics.update(rows(2, a_ref=jumped / 10, tau=jumped, tool=np.full((2, 3), 1e-3)))
    assert statistics.limit_use.jerk == pytest.approx(0.3 / DT / 1000.0)
    assert statistics.torque_rate == pytest.approx(3.0 / DT)
    assert statistics.tool_speed == pytest.approx(3**0.5)


def test_tracking_counts_only_in_motion_that_touches_nothing_outside(statistics):
    q = column((0.001, 2.0), (0.5, 2.0), (0.0, 1.998), (0.0, 2.3))
    v_ref = column((0.1, 0.0), (0.1, 0.0), (0.0, -0.1), (0.0, 0.0))
    statistics.update(rows(4, q=q, v_ref=v_ref, touches=touches(*[False] * 4)))
    assert statistics.tracking_error is None and statistics.peak is None
    statistics.begin()
    statistics.update(rows(4, q=q, v_ref=v_ref, touches=touches(True, False, True, True)))
    assert statistics.tracking_error == pytest.approx(0.002)
    assert statistics.deflection == pytest.approx(0.5)


def test_the_tracking_peak_has_joint_time_and_the_largest_effort_before(statistics):
    moving = {"v_ref": np.full((1, 2), 0.1)}
    statistics.update(rows(1, **moving, tau=column((20.0, 30.0))))
    moving["v_ref"] = np.full((2, 2), 0.1)
    statistics.update(rows(2, **moving, q=column((0.0, 2.0), (0.001, 2.003)), t=5.0 + np.arange(2)))
    error, joint, time, effort, after_contact = statistics.peak
    assert (error, joint, time) == (pytest.approx(0.003), 1, 6.0)
    assert (effort, after_contact) == (pytest.approx(0.4), None)


@pytest.mark.parametrize("length", [1, 200])
@pytest.mark.parametrize(("steps", "after_contact"), [(3, 3e-3), (99, 99e-3), (100, None)])
def test_a_contact_up_to_100_ms_before_the_tracking_peak_is_noted(
    statistics, steps, after_contact, length
):
    touched = np.arange(steps + 1) == 0
    q = np.where(np.arange(steps + 1)[:, None] == steps, [0.01, 2.0], [0.0, 2.0])
    v_ref = np.where(q == 0.01, 0.1, 0.0)
    for k in range(0, steps + 1, length):
        part = slice(k, k + length)
        block = rows(len(q[part]), q=q[part], v_ref=v_ref[part], touches=touches(*~touched[part]))
        statistics.update(block)
    assert statistics.peak.after_contact == pytest.approx(after_contact)


def test_a_joint_without_bounds_uses_none_of_its_range():
    endless = JointLimits(
        lower=np.array([-np.inf]), upper=np.array([np.inf]), velocity=np.ones(1),
        acceleration=np.ones(1), jerk=np.ones(1), effort=np.ones(1),
    )  # fmt: skip
    statistics = MotionStatistics(endless, DT)
    one = np.full((1, 1), 0.5)
    statistics.update(rows(1, q=one, v=one, q_ref=one, v_ref=one, a_ref=one, tau=one))
    assert statistics.limit_use.position == 0.0
    assert statistics.limit_use.velocity == 0.5


STILL = RobotCycle(("mug",), 10.0, max_torque_rate_nm_s=5.0)
MOVED = RobotCycle(("cube", "mug"), 20.0, max_tracking_error_rad=0.01, max_deflection_rad=0.2)


@pytest.mark.parametrize("robots", [(STILL, MOVED), (MOVED, STILL)])
def test_they_are_maxima_and_the_least_grip_force(robots):
    cycle = combined(robots)
    assert set(cycle.picked) == {"cube", "mug"} and len(cycle.picked) == 2
    assert (cycle.grip_force_n, cycle.max_deflection_rad) == (10.0, 0.2)
    assert (cycle.max_tracking_error_rad, cycle.max_torque_rate_nm_s) == (0.01, 5.0)


def test_those_of_one_robot_are_its_own():
    peak, use = TrackingPeak("joint1", "Reach", 0.5, 1.0), CycleLimitUse(0.5, 0.4, 0.3, 0.2)
    own = RobotCycle(("mug",), 10.0, 0.01, peak, 0.2, use, 3, 5.0, 0.7)
    assert all(getattr(own, one.name) != one.default for one in fields(RobotCycle))
    assert combined([own]) == own


def test_a_cycle_has_its_own_phases_and_the_grip_of_the_robot_that_grasped():
    states = {
        "left": RobotState((30.0, 20.0), ("cube",)),
        "right": RobotState((60.0, 50.0), ("mug",), 7),
    }
    robots = {name: RobotFigures("ab", LIMITS, DT, partial(states.get, name)) for name in states}
    run, alone = RunFigures(robots), RunFigures({})
    leaves = (("Lift", "up"), ("Grasp", "grip it"), ("Sleep", "rest"))
    control = {"kind": "Control", "registration": "Sequence"}
    described = [
        {"uid": 4, "path": "all", "name": "all", "parent": 0, **control},
        {"uid": 5, "path": "inner", "name": "inner", "parent": 4, **control},
    ]
    for uid, (kind, name) in enumerate(leaves, 1):
        action = {"kind": "Action", "registration": kind}
        described.append({"uid": uid, "path": name, "name": name, "parent": 5, **action})

    def handle(time, kind, **data):
        for figures in (run, alone):
            figures.handle(RunEvent(time, kind, data))

    def status(time, uid, status, robot=""):
        handle(time, "status", uid=uid, status=status, robot=robot, reason="it slept")

    assert CycleFigures().number == run.cycle(0.0).number == 1 and run.cycle(0.0).duration_s == 0.0
    handle(0.5, "tree", nodes=described)
    handle(2.0, "cycle", cycle=4, status="RUNNING")
    states["left"] = states["left"]._replace(saturated_steps=3)
    states["right"] = states["right"]._replace(saturated_steps=9)
    error = rows(3, q=column((0.0, 2.0), (0.0, 2.004), (0.0, 2.0)), v_ref=np.full((3, 2), 0.1))
    robots["left"].update(error._replace(t=2.3 + np.arange(3) * DT))
    status(2.0, 1, "RUNNING", "left")
    status(2.25, 1, "SUCCESS", "left")
    status(2.25, 2, "RUNNING", "right")
    status(2.26, 4, "RUNNING")
    assert [node.depth for node in run.executions.nodes.values()] == [0, 1, 2, 2, 2]
    assert [node.name for node in run.executions.running_leaves] == ["grip it"]
    assert run.cycle(2.5).tracking_peak.leaf == "grip it"  # it is running, as its parent is
    status(2.75, 2, "SUCCESS", "right")
    status(2.75, 3, "RUNNING")
    status(2.875, 3, "IDLE")
    status(2.9, 1, "FAILURE", "left")  # at once
    cycle = run.cycle(3.0)
    assert (cycle.number, cycle.start, cycle.duration_s) == (5, 2.0, 1.0)
    assert alone.cycle(3.0).phases == cycle.phases
    assert cycle.phases == (
        Phase("Lift", "up", "SUCCESS", "", 0.0, 0.25),
        Phase("Grasp", "grip it", "SUCCESS", "", 0.25, 0.5),
        Phase("Sleep", "rest", "HALTED", "it slept", 0.75, 0.125),
        Phase("Lift", "up", "FAILURE", "it slept", 0.9, 0.0),
    )
    assert (cycle.robots["left"].grip_force_n, cycle.robots["right"].grip_force_n) == (None, 50.0)
    assert (cycle.picked, cycle.grip_force_n, cycle.saturated_steps) == (("mug",), 50.0, 5)
    peak = cycle.tracking_peak
    assert (peak.joint, peak.leaf, peak.time_s) == ("b", "grip it", pytest.approx(0.301))
    handle(3.0, "cycle", cycle=5, status="RUNNING")
    assert run.cycle(3.5).phases == () and run.cycle(3.5).saturated_steps == 0
