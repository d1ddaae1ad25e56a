"""What the tests share: drawing, and a cell with a camera over a table."""

from dataclasses import replace

import pytest

from tests.support.drawing import opengl as opengl
from tests.support.drawing import (
    processes_draw_if_their_test_does as processes_draw_if_their_test_does,
)
from tests.support.program import bt_manip as bt_manip

EYE, TARGET = (0.3, -0.45, 1.55), (0.3, 0.1, 1.0)


@pytest.fixture
def see(opengl, parts):
    """Make a cell with a table, a cube and a camera of given parameters."""
    from bt_manip.cell import Cell, looking_at  # after MUJOCO_GL is set
    from bt_manip.cell.objects import Cube
    from bt_manip.spatial import pose
    from bt_manip_camera.camera import DepthCamera

    def make(**parameters):
        cell, camera = Cell(), DepthCamera(**parameters)
        with cell.editing():
            cell.add(parts.objects.create("table"), pose((0.3, 0.0, 0.0)), name="table", free=False)
            top = cell.surface_height("table")
            cell.add(Cube(size=0.05), pose((0.3, 0.1, top + 0.025)), name="cube")
            cell.add(camera, looking_at(EYE, TARGET), name="camera", free=False)
        return cell, camera

    return make


@pytest.fixture(scope="session")
def situations(build_station):
    from bt_manip.testing import AT_REST, Situations

    situations = Situations(build_station)
    situations.add(AT_REST, lambda station: station.cell.step(100), after=None)
    situations.add("a cube", put_cube)
    situations.add("a cube that the camera sees", look_at_it, after="a cube")
    situations.add("holding a cube over the table", pick_it, after="a cube")  # as for faults
    return situations


def put_cube(station):
    """A cube on the table."""
    from bt_manip.spatial import pose

    cube = station.models.create("cube", size=0.07)
    station.cell.add(cube, pose((0.3, 0.05, 1.05)), name="cube")
    station.cell.step(100)


def look_at_it(station):
    """The camera on the hand looks at it."""
    from bt_manip.testing import play
    from bt_manip_camera.behaviours import LookAt

    play(station, LookAt(object="cube"))


def pick_it(station):
    """The cube is in the hand, over the table."""
    from bt_manip.behaviours import Grasp, Hover, Lift, Reach
    from bt_manip.testing import play

    play(station, Hover(object="cube"), Reach(object="cube"), Grasp(object="cube"), Lift())


@pytest.fixture(scope="session")
def small_images():
    """Give a function that returns a scene with a quarter of the pixels: enough, and faster."""

    def reduce(scene):
        return replace(scene, objects=tuple(
            replace(one, parameters={**one.parameters, "width": 320, "height": 240})
            if one.model == "depth_camera" else one for one in scene.objects
        ))  # fmt: skip

    return reduce


@pytest.fixture(scope="session")
def build_station(parts, opengl, small_images):
    from bt_manip import build_station as build

    return lambda: build(parts, scene=small_images(parts.scenes.create("table_seen")))


@pytest.fixture(scope="session")
def shared_run(parts, opengl, small_images):
    """One run for all tests: to build it takes longer than to run it."""
    from bt_manip.runner import prepare, request_of

    scene = small_images(parts.scenes.create("table_seen"))
    return prepare(request_of("pick_place_seen", parts, poses="seen", scene=scene), parts)


@pytest.fixture
def run(shared_run):
    """Give the run as it was built."""
    shared_run.begin_episode(0, seed=1)
    return shared_run


@pytest.fixture
def believe_off(monkeypatch):
    """Let all objects be believed at a distance from where they are seen [m]."""
    from bt_manip_camera.seen import SeenPoses

    report = SeenPoses.report

    def off(*distance):
        def wrong(self, found):
            found.T_wo.translation += distance
            report(self, found)

        monkeypatch.setattr(SeenPoses, "report", wrong)

    return off
