"""The tree knows what cameras have seen; the physics judges."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.bt import NodeStatus
from bt_manip.cell import looking_at
from bt_manip.cell.randomization import Randomization
from bt_manip.exceptions import BtManipError
from bt_manip.runner import RunLoop, RunObserver, prepare, request_of
from bt_manip.scenes import SceneObject
from bt_manip.spatial import pose
from bt_manip_camera.behaviours import IsSeen
from bt_manip_camera.estimation import Estimate
from bt_manip_camera.seen import SeenPoses


class Beliefs(RunObserver):
    """Compares the believed cell with the physics, where the cube is moved while it is reached."""

    def __init__(self, station, T_wo):
        self.station, self.T_wo, self.moved = station, T_wo, False
        self.joints, self.objects, self.held = [], [], []

    def after_tick(self):
        station, believed = self.station, self.station.believed.cell
        assert believed.time == station.cell.time
        q = station.robot.q
        self.joints.append(np.abs(station.believed.robots["arm"].robot.q - q).max())
        if "cube" in believed.entities:
            gap = believed.pose("cube").translation - station.cell.pose("cube").translation
            self.objects.append(np.linalg.norm(gap[:2]))
            self.held.append(bool(station.believed.robots["arm"].gripper.held))
            if not self.moved and station.cell.time > 1.0:  # it hovers
                station.cell.move("cube", self.T_wo)
                self.moved = True


def test_the_tree_picks_what_it_has_seen_looks_again_where_it_is_not_and_the_physics_judges(run):
    there = run.station.cell.pose("cube").translation
    aside = pose((0.3, 0.2 if there[1] < 0 else -0.2, there[2]))
    watch = Beliefs(run.station, aside)
    with RunLoop(run, [watch]) as loop:
        ended = loop.cycle()
    assert ended.succeeded, ended.reason
    assert run.goal.holds and watch.moved
    assert max(watch.joints) == 0.0
    assert 0.0 < watch.objects[0] < 5e-3  # seen, not known
    assert any(watch.held) and not watch.held[-1]


def test_a_run_has_the_same_states_again_and_from_a_state_in_the_middle(run):
    hand = run.station.believed.robots["arm"].gripper

    def advance(ticks=30):
        """Continue from where the cube is held; give the states of both cells."""
        with RunLoop(run) as loop:
            loop.begin()
            while not hand.held:
                assert loop.advance() is NodeStatus.RUNNING
            state = run.get_state()
            for _ in range(ticks):
                assert loop.advance() is NodeStatus.RUNNING
        return state, [cell.state_bytes() for cell in (run.station.cell, run.station.believed.cell)]

    state, first = advance()
    run.set_state(json.loads(json.dumps(state)))
    assert hand.held == ("cube",)
    assert advance()[1] == first
    run.begin_episode(0, seed=1)
    assert advance()[1] == first


def test_a_grasp_by_a_wrong_belief_fails(run, believe_off):
    believe_off(0.0, 0.12, 0.0)
    (grasp,) = (node for node in run.tree.nodes if node.registration == "Grasp")
    with RunLoop(run) as loop:
        loop.begin()
        while grasp.status.name not in ("SUCCESS", "FAILURE"):
            assert loop.advance() is NodeStatus.RUNNING
    assert grasp.status.name == "FAILURE"
    assert not run.station.believed.robots["arm"].gripper.held


def test_seen_poses_need_a_camera(parts, opengl):
    request = request_of("pick_place", parts, poses="seen")
    with pytest.raises(BtManipError, match="--poses seen needs a scene with a depth_camera"):
        prepare(request, parts)


@pytest.fixture(scope="module")
def overhead(parts, opengl, small_images):
    """A run of pick_place, which does not look, with a camera over the table."""
    scene = parts.scenes.create("table_seen")
    kept = [one for one in scene.objects if one.model not in ("cube", "depth_camera")]
    T_wc = looking_at((0.4, 0.0, 2.2), (0.4, 0.0, 1.0))
    above = SceneObject("depth_camera", "above", T_wc, {"fovy": 30.0, "rate": 5.0})
    scene = replace(scene, objects=(*kept, above), randomization=Randomization())
    scene = small_images(scene)
    return prepare(request_of("pick_place", parts, poses="seen", scene=scene), parts)


def test_what_a_tree_adds_is_there_once_a_camera_has_seen_it(overhead):
    overhead.begin_episode(0, seed=2)
    physics, believed = overhead.station.cell, overhead.station.believed.cell
    with RunLoop(overhead) as loop:
        loop.begin()
        while "cube" not in believed.entities:
            assert loop.advance() is NodeStatus.RUNNING
        gap = believed.pose("cube").translation - physics.pose("cube").translation
    assert 1e-5 < np.linalg.norm(gap) < 8e-3  # seen, from 1.2 m
    overhead.station.believed.poses.taken("cube")
    assert "cube" not in physics.entities


def test_what_is_not_expected_is_where_the_physics_has_it_from_the_start_of_a_cycle(run):
    station = run.station
    T_wo = station.cell.pose("basket") * pose((0.02, -0.03, 0.0), (0.8, 0.0, 0.0, 0.6))
    station.cell.move("basket", T_wo)
    assert not station.believed.cell.pose("basket").isApprox(T_wo)
    station.believed.begin()
    assert station.believed.cell.pose("basket").isApprox(T_wo)


def test_what_a_tree_adds_out_of_sight_is_waited_for_in_vain(overhead):
    overhead.begin_episode(0, seed=2)
    with RunLoop(overhead, [Hide(overhead.station)]) as loop:
        ended = loop.cycle(in_place=True)
    assert "'cube' was not seen: look first, by WaitUntilSeen ('cube' is not seen" in ended.reason
    assert 1.0 < overhead.station.cell.time < 1.2


class Hide(RunObserver):
    """Moves the cube out of sight as soon as it is in the physics."""

    def __init__(self, station):
        self.station = station

    def before_tick(self):
        if "cube" in self.station.cell.entities:
            self.station.cell.move("cube", pose((-0.2, 0.6, 1.05)))


def test_without_opengl_nothing_starts(parts, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with pytest.raises(
        BtManipError, match="nothing can be drawn with MUJOCO_GL disable; .*MUJOCO_GL=egl"
    ):
        prepare(request_of("pick_place_seen", parts, poses="seen"), parts)


def test_state_of_what_was_seen_is_plain_data():
    source, other = SeenPoses(()), SeenPoses(())
    source.lose("can")
    T_wo = pose((0.1, 0.2, 0.3), (0.6, 0.0, 0.0, 0.8))
    source.report(Estimate("cube", T_wo, 1e-3, 2e-3, 0.5, "eye"))
    other.set_state(source.get_state())
    assert other.seen["cube"].T_wo.isApprox(T_wo)
    seen = other.seen["cube"]
    assert (seen.position_error, seen.yaw_error, seen.time, seen.camera) == (1e-3, 2e-3, 0.5, "eye")
    assert other.lost == {"can"}
    seen = IsSeen(object="cube", max_age=2.0, max_error=0.9e-3)
    seen.setup(cell=SimpleNamespace(time=2.6), poses=SimpleNamespace(source=other))
    assert seen.why_not() == "'cube' was seen 2.1 s ago"
    seen.setup(cell=SimpleNamespace(time=2.4), poses=SimpleNamespace(source=other))
    assert seen.why_not() == "'cube' is known to 1.0 mm only"


class Known(RunObserver):
    """Notes which blocks there are, and which of them the tree knows, whenever it changes."""

    def __init__(self, station):
        self.cells, self.noted = (station.cell, station.believed.cell), []

    def after_tick(self):
        both = [{*cell.objects} - {"table", "tray", "eye"} for cell in self.cells]
        if self.noted[-1:] != [both]:
            self.noted.append(both)


def test_blocks_are_stacked_where_they_were_seen(parts, opengl, small_images):
    scene = small_images(parts.scenes.create("table_and_tray_seen"))
    run = prepare(request_of("stack_blocks_seen", parts, poses="seen", scene=scene), parts)
    known = Known(run.station)
    with RunLoop(run, [known]) as loop:
        ended = loop.cycle()
    four = {"red", "green", "blue", "yellow"}
    assert known.noted == [[four, set()], [four, four]]  # scattered, then seen
    assert ended.succeeded, ended.reason
    assert run.goal.holds
