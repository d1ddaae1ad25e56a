"""The position from which all points are seen."""

import contextlib
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.cell import CellScene
from bt_manip.viewer.page import SceneView
from bt_manip.viewer.page.framing import FRAMED_SHARE
from bt_manip.viewer.page.server import close_server, open_server


@pytest.fixture(scope="module")
def framing(parts):
    server = open_server(0)
    cell = build_station(parts).cell
    view = SceneView(server)
    view.bind(CellScene(cell.model, cell.data, cell.entities))
    yield view._framing
    close_server(server)


@pytest.mark.parametrize("aspect", [0.5, 1.0, 1.6, 3.0])
def test_all_corners_are_inside_and_two_of_them_touch_the_margin(framing, aspect):
    position, look_at = framing._placed(aspect)
    forward = (look_at - position) / np.linalg.norm(look_at - position)
    np.testing.assert_allclose(forward, framing._axes[:, 2], atol=1e-9)
    right, up, depth = ((framing._points - position) @ framing._axes).T
    assert (depth > 0.0).all()
    slope = np.tan(framing._fov / 2.0)
    shares = np.stack([abs(right) / (depth * slope * aspect), abs(up) / (depth * slope)])
    assert shares.max() == pytest.approx(FRAMED_SHARE)
    assert (abs(shares - FRAMED_SHARE) < 1e-9).sum() >= 2


class Camera:
    """The camera of a client, as viser has it."""

    image_width, image_height, aspect, fov = 800, 600, 4 / 3, 0.8

    def __init__(self, position):
        self.position = self.look_at = np.array(position)

    def on_update(self, call):
        self.report = lambda: call(None)


@pytest.fixture
def client(framing):
    client = SimpleNamespace(
        client_id=99, camera=Camera((3.0, 3.0, 3.0)), atomic=contextlib.nullcontext
    )
    framing._connected(client)
    return client


def test_a_camera_that_somebody_has_moved_is_left_alone(framing, client):
    moved = client.camera.position = client.camera.position + 0.1
    client.camera.report()
    client.camera.image_width = 400
    client.camera.report()
    np.testing.assert_array_equal(client.camera.position, moved)


def test_a_camera_that_viser_puts_to_its_initial_position_is_placed_again(framing, client):
    placed = client.camera.position
    client.camera.position = np.array(framing._server.initial_camera.position)
    client.camera.report()
    np.testing.assert_allclose(client.camera.position, placed)
