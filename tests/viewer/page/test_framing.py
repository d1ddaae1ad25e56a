"""The position from which all points are seen."""

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


def test_a_camera_that_somebody_has_moved_is_left_alone(framing):
    camera = SimpleNamespace(moved=True, own=[np.zeros(3)])
    framing._place(None, camera)  # would fail with a client
    assert len(camera.own) == 1
