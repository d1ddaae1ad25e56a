"""The recorded scene at a time is the scene of the run after that tick."""

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.behaviours import MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import Sequence, Sleep, Tree
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip.runner import Run, RunObserver, RunRequest, TreeSource
from bt_manip_recording import CellScene, McapRecorder, RecordedScene, Recording


class Watch(RunObserver):
    """Keep the scene after each tick."""

    def run_started(self, run):
        self.cell, self.seen = run.station.cell, {}

    def after_tick(self):
        cell = self.cell
        scene = CellScene(cell.model, cell.data, cell.entities)
        present = scene.entities()
        poses = dict(zip(scene.frames, scene.poses(), strict=True))
        self.seen[round(cell.time, 9)] = present, poses, scene.cameras


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Record two cycles in which an object comes and goes."""
    path = tmp_path_factory.mktemp("scene") / "run.mcap"
    station = build_station(load_plugins(entry_points=()).parts)
    root = Sequence(
        "root",
        Sleep("wait", msec=50),
        SpawnObject(object="{cube}"),
        MoveToConfiguration(configuration=[0.1, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        Sleep("hold", msec=30),
        RemoveObject(object="{cube}"),
        Sleep("rest", msec=50),
    )
    tree = Tree(root, clock=station.clock)
    tree.setup(**station.infrastructure)
    watch = Watch()
    run = Run(RunRequest(TreeSource("test", "python"), cycles=2), tree, station)
    run.execute([watch, McapRecorder(path)])
    return path, watch


@pytest.fixture
def scene(recorded):
    return RecordedScene(Recording(recorded[0]))


def test_entities_and_poses_at_any_time_are_those_of_the_run(recorded, scene):
    _, watch = recorded
    times = list(watch.seen)
    np.random.default_rng(0).shuffle(times)
    for time in times:
        scene.seek(time)
        present, poses, _ = watch.seen[time]
        assert scene.time == pytest.approx(time)
        assert set(scene.entities()) == set(present)
        found = dict(zip(scene.frames, scene.poses(), strict=True))
        for name in set(found) & set(poses):
            np.testing.assert_array_equal(found[name], poses[name])
        assert {n for n in poses if n.startswith(("panda/link", "cube/"))} <= set(found)


def test_between_two_ticks_it_is_that_of_the_first(scene):
    scene.seek(0.037)
    assert scene.time == pytest.approx(0.03)
    scene.seek(-1.0)
    assert scene.time == 0.0
    scene.seek(1e9)
    assert scene.index == len(scene.times) - 1


def test_before_the_first_tick_the_robot_is_where_it_starts(recorded, scene):
    _, watch = recorded
    scene.seek(0.0)
    hand = list(scene.frames).index("panda/hand")
    assert scene.entities().keys() == {"world", "table", "basket", "panda"}
    first = watch.seen[0.01][1]["panda/hand"]
    np.testing.assert_allclose(scene.poses()[hand], first, atol=1e-3)


def test_shapes_are_those_of_the_cell(recorded, scene):
    _, watch = recorded
    cell = watch.cell
    live = CellScene(cell.model, cell.data, cell.entities)
    for entity in scene.entities():
        expected, found = live.shapes(entity), scene.shapes(entity)
        assert found.keys() == expected.keys()
        for frame, shapes in expected.items():
            assert sorted(s.kind for s in shapes) == sorted(s.kind for s in found[frame])
            by_kind = sorted(
                shapes, key=lambda s: ("box", "ellipsoid", "cylinder", "mesh").index(s.kind)
            )
            for one, other in zip(by_kind, found[frame], strict=True):
                np.testing.assert_array_equal(one.position, other.position)
                np.testing.assert_array_equal(one.quat_wxyz, other.quat_wxyz)
                assert one.size == other.size and one.rgba == other.rgba
                if one.triangles is not None:
                    np.testing.assert_array_equal(one.triangles.vertices, other.triangles.vertices)
                    np.testing.assert_array_equal(one.triangles.faces, other.triangles.faces)


def test_an_object_that_comes_back_looks_different(recorded, scene):
    looks = []
    for time in scene.times:
        scene.seek(time)
        if "cube" in scene.entities():
            looks.append(scene.entities()["cube"])
    assert len(set(looks)) == 2


def test_cameras_are_recorded(recorded, scene):
    _, watch = recorded
    for time, (_, _, cameras) in watch.seen.items():
        scene.seek(time)
        for one, other in zip(scene.cameras, cameras, strict=True):
            assert (one.name, one.frame, one.fovy) == (other.name, other.frame, other.fovy)
            np.testing.assert_array_equal(one.position, other.position)
            np.testing.assert_array_equal(one.quat_wxyz, other.quat_wxyz)
    assert scene.extent > 0.0 and scene.centre.shape == (3,)


def test_a_recording_without_a_complete_chunk_has_no_scene(recorded, tmp_path):
    path, _ = recorded
    (tmp_path / "cut.mcap").write_bytes(path.read_bytes()[:1000])
    with pytest.raises(BtManipError, match=r"cut.mcap has no complete chunk"):
        RecordedScene(Recording(tmp_path / "cut.mcap"))
