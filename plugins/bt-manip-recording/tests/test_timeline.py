"""Events, joints and scene of a recording after a tick are those of the run before the next one."""

from itertools import pairwise

import numpy as np
import pytest
from mcap.reader import make_reader

from bt_manip.behaviours import MoveToConfiguration
from bt_manip.runner import RunObserver
from bt_manip_recording import (
    CellScene,
    McapRecorder,
    RecordedScene,
    Recording,
    Timeline,
    mcap_file,
)
from tests.support.recorded import coming_and_going
from tests.support.runs import Listener


class States(RunObserver):
    """Keep the events before each tick, and joints and scene after it."""

    def __init__(self, events):
        self.events, self.seen, self.joints, self.scenes = events, [], [], {}

    def run_started(self, run):
        self.cell, self.robot, self.arm = run.station.cell, run.station.robot, run.station.arm

    def before_tick(self):
        self.seen.append([event for event in self.events if event.kind != "tick"])

    def after_tick(self):
        self.joints.append((self.robot.q.copy(), self.arm.q.copy()))
        scene = CellScene(self.cell.model, self.cell.data, self.cell.entities)
        poses = dict(zip(scene.frames, scene.poses(), strict=True))
        self.scenes[round(self.cell.time, 9)] = scene.entities(), poses, scene.cameras


@pytest.fixture(scope="module")
def recorded(make_run, tmp_path_factory):
    """Record two cycles in several chunks; an object comes and goes in each."""
    path = tmp_path_factory.mktemp("timeline") / "run.mcap"
    events = []
    states = States(events)
    run = make_run(coming_and_going(rest=200), cycles=2)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mcap_file, "CHUNK_DURATION", 0.2)
        run.execute([Listener(events, McapRecorder.kinds), McapRecorder(path), states])
    return path, states


@pytest.fixture(scope="module")
def timeline(recorded):
    return Timeline(Recording(recorded[0]))


@pytest.fixture
def scene(recorded):
    return RecordedScene(Recording(recorded[0]))


def test_each_state_has_the_events_of_the_run_so_far_in_pieces_too(recorded, timeline):
    _, states = recorded
    assert len(timeline.scene.times) == len(states.seen) + 1
    for i, expected in enumerate(states.seen):
        found = timeline.events(-1, i)
        assert [(e.kind, e.data) for e in found] == [(e.kind, e.data) for e in expected]
        assert [e.time for e in found] == pytest.approx([e.time for e in expected])
    last = len(timeline.scene.times) - 1
    pieces = [timeline.events(i, j) for i, j in pairwise([-1, 0, 3, 4, 20, last])]
    assert [event for piece in pieces for event in piece] == timeline.events(-1, last)


def test_joints_are_those_at_the_end_of_each_tick(recorded, timeline):
    _, states = recorded
    times, joints = timeline.joints(1, len(states.joints) + 1)
    np.testing.assert_array_equal(times, timeline.scene.times[1:])
    expected = np.array(states.joints)
    np.testing.assert_array_equal(joints["panda"][0], expected[:, 0])
    np.testing.assert_array_equal(joints["panda"][1], expected[:, 1])
    assert np.isnan(timeline.joints(0, 1)[1]["panda"]).all()


def test_a_cut_recording_has_the_states_up_to_its_last_complete_chunk(recorded, tmp_path):
    path, states = recorded
    with path.open("rb") as file:
        chunk = make_reader(file).get_summary().chunk_indexes[-2]
    end = chunk.chunk_start_offset + chunk.chunk_length
    (tmp_path / "cut.mcap").write_bytes(path.read_bytes()[: end + 5])
    cut = Recording(tmp_path / "cut.mcap")
    assert not cut.complete
    timeline = Timeline(cut)
    assert 1 < len(timeline.scene.times) <= len(states.seen)
    for i in range(len(timeline.scene.times) - 1):
        assert len(timeline.events(-1, i)) == len(states.seen[i])


def test_while_an_interrupted_run_stops_its_arms_time_goes_on(make_run, tmp_path):
    path = tmp_path / "run.mcap"
    run = make_run(MoveToConfiguration(configuration=[0.1, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]))
    run.execute([McapRecorder(path)], stop=lambda: run.station.cell.time > 0.1)
    timeline = Timeline(Recording(path))
    times, ticks = timeline.scene.times, timeline.scene.ticks
    assert ticks[-1] == ticks[-2] and times[-1] > times[-2] > 0.1
    kinds = [
        (event.kind, event.data.get("moving")) for event in timeline.events(-1, len(times) - 1)
    ]
    assert kinds[-1] == ("motion", False)
    assert ("motion", False) not in [(e.kind, e.data.get("moving")) for e in timeline.events(-1, 5)]


def test_entities_poses_and_cameras_at_any_time_are_those_of_the_run(recorded, scene):
    _, states = recorded
    times = list(states.scenes)
    np.random.default_rng(0).shuffle(times)
    for time in times:
        scene.seek(time)
        present, poses, cameras = states.scenes[time]
        assert scene.time == pytest.approx(time)
        assert set(scene.entities()) == set(present)
        found = dict(zip(scene.frames, scene.poses(), strict=True))
        for name in set(found) & set(poses):
            np.testing.assert_array_equal(found[name], poses[name])
        assert {n for n in poses if n.startswith(("panda/link", "cube/"))} <= set(found)
        for one, other in zip(scene.cameras, cameras, strict=True):
            assert (one.name, one.frame, one.fovy) == (other.name, other.frame, other.fovy)
            np.testing.assert_array_equal(one.position, other.position)
            np.testing.assert_array_equal(one.quat_wxyz, other.quat_wxyz)
    stat = states.cell.model.stat
    np.testing.assert_allclose([*scene.centre, scene.extent], [*stat.center, stat.extent])


def test_between_two_ticks_it_is_that_of_the_first_and_before_them_that_of_the_start(
    recorded, scene
):
    _, states = recorded
    scene.seek(0.037)
    assert scene.time == pytest.approx(0.03)
    scene.seek(1e9)
    assert scene.index == len(scene.times) - 1
    scene.seek(-1.0)
    assert scene.time == 0.0
    hand = list(scene.frames).index("panda/hand")
    assert scene.entities().keys() == {"world", "table", "basket", "panda"}
    first = states.scenes[0.01][1]["panda/hand"]
    np.testing.assert_allclose(scene.poses()[hand], first, atol=1e-3)


def test_shapes_are_those_of_the_cell(recorded, scene):
    def described(shape):
        mesh = [] if shape.triangles is None else [part.tolist() for part in shape.triangles]
        pose = [*shape.position, *shape.quat_wxyz]
        return shape.kind, pose, shape.size, shape.rgba, mesh

    cell = recorded[1].cell
    live = CellScene(cell.model, cell.data, cell.entities)
    for entity in scene.entities():
        expected, found = live.shapes(entity), scene.shapes(entity)
        assert found.keys() == expected.keys()
        for frame, shapes in expected.items():
            assert sorted(map(described, found[frame])) == sorted(map(described, shapes))


def test_an_object_that_comes_back_looks_different(recorded, scene):
    looks = []
    for time in scene.times:
        scene.seek(time)
        if "cube" in scene.entities():
            looks.append(scene.entities()["cube"])
    assert len(set(looks)) == 2
