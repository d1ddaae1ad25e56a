"""The position from which all points are seen."""

import time

import msgspec
import numpy as np
import pytest
import trimesh

from bt_manip import build_station, spatial
from bt_manip.bt import Sleep
from bt_manip.cell.objects import Cube
from bt_manip_recording import CellScene
from bt_manip_view.page.framing import FRAMED_SHARE, NOT_FRAMED, rotated
from bt_manip_view.page.history import History

from .conftest import CAMERA, wait_until


@pytest.fixture
def station(make_run, page):
    station = make_run(Sleep(msec=10)).station
    page.begin_idle(station)
    return station


@pytest.fixture
def report(station, scene):
    """Give a function that reports a camera, and returns where the page puts it."""

    def report(**camera):
        scene.camera.clear()
        scene.connection.send(msgspec.msgpack.encode(CAMERA | camera))
        wait_until(lambda: scene.see().camera.keys() >= {"position", "look_at", "fov"})
        return [np.array(scene.camera[key]) for key in ("position", "look_at", "fov")]

    return report


def corners_of(cell):
    """Return the corners of the boxes around the shapes that have to be seen [m]."""  # (n, 3)
    source, corners = CellScene(cell.model, cell.data, cell.entities), []
    poses = dict(zip(source.frames, source.poses(), strict=True))
    for name in source.entities().keys() - set(NOT_FRAMED):
        for body, shapes in source.shapes(name).items():
            for shape in shapes:
                half = np.array(shape.size) / 2.0
                bounds = np.array([-half, half])
                if shape.triangles is not None:
                    vertices = shape.triangles.vertices
                    bounds = np.array([vertices.min(axis=0), vertices.max(axis=0)])
                box = rotated(shape.quat_wxyz, trimesh.bounds.corners(bounds)) + shape.position
                corners.append(rotated(poses[body][3:], box) + poses[body][:3])
    return np.concatenate(corners)


@pytest.mark.parametrize("aspect", [0.5, 3.0])
def test_all_corners_are_inside_and_two_of_them_touch_the_margin(station, report, aspect):
    position, look_at, fov = report(image_width=round(800 * aspect), image_height=800)
    forward = (look_at - position) / np.linalg.norm(look_at - position)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(right, forward), forward])
    across, up, depth = ((corners_of(station.cell) - position) @ axes).T
    assert (depth > 0.0).all()
    slope = np.tan(fov / 2.0)
    shares = np.stack([abs(across) / (depth * slope * aspect), abs(up) / (depth * slope)])
    assert shares.max() == pytest.approx(FRAMED_SHARE, abs=1e-4)
    assert (abs(shares - FRAMED_SHARE) < 1e-4).sum() >= 2


def test_a_camera_that_somebody_has_moved_is_left_alone(report, scene):
    position, _, _ = report()
    moved = CAMERA | {"position": (position + 0.1).tolist()}
    scene.camera.clear()
    for camera in (moved, moved | {"image_width": 400}):
        scene.connection.send(msgspec.msgpack.encode(camera))
    time.sleep(0.2)
    assert not scene.see().camera


def test_a_camera_that_viser_puts_to_its_initial_position_is_placed_again(page, report):
    placed = report()
    again = report(position=page.server.initial_camera.position.tolist())
    np.testing.assert_allclose(again[0], placed[0])


def test_an_object_that_is_not_yet_in_a_past_state_does_not_move_the_camera(parts, page, report):
    report()
    past, cell = History(), build_station(parts).cell
    for x in (0.5, 0.7):  # without an object, then with one
        source = CellScene(cell.model, cell.data, cell.entities)
        past.look(source)
        past.end_tick(cell.time, source.poses(), {})
        cell.add(Cube(), spatial.pose((x, 0.0, 0.5)))
    for past.index in (1, 0):
        page.view.bind(past.scene)
        page.view._framing._next = 0.0  # it looks once a second
        page.view.update()
    assert all(np.isfinite(value).all() for value in report(image_width=500))
