"""A description is tried by the task itself, and a failure names the key that may cause it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.behaviours import Lift
from bt_manip.bt import NodeStatus
from bt_manip.robots import panda
from bt_manip_setup import trial as module
from bt_manip_setup import try_robot

GRIPPER = panda().gripper


def keys(trial) -> list[str]:
    return [finding.split("key '")[1].split("'")[0] for finding in trial.findings]


def test_a_robot_that_picks_has_no_findings(parts, monkeypatch):
    steps: list[str] = []
    built = []

    def build(*given, **named):
        station = build_station(*given, **named)
        built.extend((station, station.robot.tool_pose.translation))
        return station

    monkeypatch.setattr(module, "build_station", build)
    trial = try_robot(panda(), parts, cycles=1, report=steps.append)
    assert trial.findings == []
    assert steps == ["a cube on a post", "pick_place: cycle 1 of 1"]
    assert trial.facts[0] == "pick_place: 1 of 1 cycles, 0 of them with a retry"
    assert trial.facts[1].startswith("tracking error: 0.")
    (station, start), cell = built, built[0].cell
    top = cell.surface_height("table")
    post, cube = cell.pose("post").translation, cell.pose("cube").translation
    roots = cell.model.body_rootid[cell.model.geom_bodyid]
    size = cell.model.geom_size[roots == cell.body_id("post")]
    assert size.tolist() == [[0.01, 0.01, 0.03]]
    assert post[2] == pytest.approx(top + 0.03)  # it stands on the table, 6 cm high
    assert cube[2] == pytest.approx(top + 0.025, abs=1e-3)  # set down on the table beside it
    assert 0.099 < np.linalg.norm(cube[:2] - post[:2]) < 0.15
    area = station.first.reach.area(cell, "table", 0.06)
    nearest = np.clip(start[:2], *np.transpose([area.x, area.y]))
    assert post[:2] == pytest.approx(nearest, abs=0.026)  # of points 50 mm apart


def test_cycles_with_failed_actions_and_the_worst_joint_become_findings():
    events, begun = [], []
    arm = SimpleNamespace(moving=True, q_ref=np.array([0.5, -0.2, 0.1]))
    described = SimpleNamespace(arm_joints=("a", "b", "c"))
    robot = SimpleNamespace(q=np.zeros(3), description=described)
    contacts = SimpleNamespace(free=True)
    cell = SimpleNamespace(contact_monitor=SimpleNamespace(summary=lambda: contacts))
    station = SimpleNamespace(cell=cell, first=SimpleNamespace(arm=arm, robot=robot))
    watch = module.TrialWatch(begun.append)
    watch.run_started(SimpleNamespace(station=station, tree=SimpleNamespace(observers=events)))
    lift = Lift(height=0.05)
    lift.feedback_message = "the cube was lost after 3 s"
    for cycle, (failures, status) in enumerate("1S 0S 0S 0S 1S 2F 0F 0S".split()):
        watch.cycle_started(cycle)
        for _ in range(int(failures)):
            events[0](lift, NodeStatus.RUNNING, NodeStatus.FAILURE)
            events[0](lift, NodeStatus.FAILURE, NodeStatus.RUNNING)
        watch.cycle_ended({"S": "SUCCESS", "F": "FAILURE"}[status], "out of reach by 2 mm")
        if cycle == 3:
            assert list(watch.findings("it")) == []  # a quarter with a retry
        if cycle == 4:
            (retried,) = watch.findings("it")
            assert "pick_place, 2 of 5 cycles: Lift: the cube was lost after 3 s" in retried
    assert (watch.cycles, watch.failed, watch.retried) == (8, 2, 2)
    assert begun == list(range(1, 9))
    for error, found in ((0.0095, False), (0.0105, True)):  # [rad]
        robot.q = arm.q_ref - (error, 0.0, 0.0)
        watch.after_tick()
        assert ("a is up to" in "".join(watch.findings("it"))) == found
    for free, moving, q in ((0, 1, (9, 0, 0)), (1, 0, (9, 0, 0)), (1, 1, (0.495, -0.232, 0.125))):
        contacts.free, arm.moving, robot.q = bool(free), bool(moving), np.array(q)
        watch.after_tick()
    robot.q = np.array([0.49, -0.2, 0.1])
    watch.after_tick()
    first, second, third = watch.findings("it")
    assert "key 'gripper': pick_place, 3 of 8 cycles: Lift: the cube was lost after 3 s" in first
    assert "key 'base': pick_place, 1 of 8 cycles: out of reach by 2 mm" in second
    assert "key 'armature': b is up to 32 mrad from its reference" in third


def test_a_grip_too_weak_for_the_cube_is_found_in_the_air_and_once_on_the_table(parts):
    weak = try_robot(replace(panda(), gripper=replace(GRIPPER, max_force=0.2)), parts, cycles=20)
    assert set(keys(weak)) == {"gripper.max_force"}
    assert "a cube on a post: Hover" in weak.findings[0]
    assert "robot 'panda'" in weak.findings[0] and "; give more" in weak.findings[0]
    (table,) = (finding for finding in weak.findings if "pick_place" in finding)
    assert "pick_place, 3 of 3 cycles: Hover: " in table  # and no further cycles are run


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"effort": (87.0, 87.0, 87.0, 87.0, 12.0, 1.9, 12.0)}, "effort"),
        ({"T_rb": spatial.pose((-2.0, 0.0, 0.0))}, "base"),
        ({"T_ft": spatial.pose((0.0, 0.0, -0.1))}, "tool"),
    ],
)
def test_the_cause_is_named_before_what_fails_with_it(parts, changes, key):
    trial = try_robot(replace(panda(), **changes), parts, cycles=1)
    assert keys(trial)[0] == key
