"""AprilTags are read and measured by the library of others that detects them."""

from functools import cache

import numpy as np
import pytest

from bt_manip.cell import Cell, looking_at
from bt_manip.exceptions import BtManipError
from bt_manip.spatial import pose
from bt_manip_camera.camera import DepthCamera
from bt_manip_camera.tags import CODES, Tag, detect_tags, tag_detector, tag_image


@pytest.fixture(scope="module")
def library():
    return pytest.importorskip("pupil_apriltags", reason="pupil-apriltags is not installed")


def put(tags):
    """Give a cell with tags, by number, place and yaw, and a camera over them."""
    cell, camera = Cell(), DepthCamera()
    with cell.editing():
        for number, place, yaw in tags:
            cell.add(Tag(number=number), lying(place, yaw), name=f"tag_{number}", free=False)
        at = looking_at((0.3, -0.3, 1.5), (0.3, 0.0, 1.0))
        cell.add(camera, at, name="camera", free=False)
    return cell, camera


def lying(place, yaw):
    return pose((*place, 1.0), (np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)))


def test_each_tag_has_its_number(library, opengl):
    number = len(CODES)
    places = [(0.1 + 0.1 * (i % 4), -0.15 + 0.1 * (i // 4)) for i in range(number)]
    _, camera = put([(i, places[i], 0.3 * i) for i in range(number)])
    seen = detect_tags(camera.expose(np.random.default_rng(0)), 0.032)
    assert [one.number for one in seen] == list(range(number))


def test_the_picture_of_a_tag_is_on_its_plate_and_its_top_is_the_frame():
    cell, tag = Cell(), Tag()
    assert tag_image(3).shape == (160, 160, 3)
    assert tag.rest_height == pytest.approx(2.1e-3)
    cell.add(tag, pose((0.0, 0.0, 1.0)), name="tag", free=False)
    plate, picture = (cell.model.geom(f"tag/{name}").id for name in ("plate", "picture"))
    for geom, bottom, top in ((plate, -tag.rest_height, -1e-4), (picture, -1e-4, 0.0)):
        half, centre = cell.model.geom_size[geom], cell.data.geom_xpos[geom]
        assert half[:2] == pytest.approx([0.02, 0.02])  # 10 of the square's 8 cells
        assert (centre - half)[2] == pytest.approx(1.0 + bottom, abs=1e-9)
        assert (centre + half)[2] == pytest.approx(1.0 + top, abs=1e-9)


@cache
def tags_seen(number):
    """Give frames of a tag, with its position and yaw, which are random, and the camera's."""
    rng, found, (cell, camera) = np.random.default_rng(3), [], put([(5, (0.3, 0.0), 0.0)])
    for _ in range(number):
        at, yaw = rng.uniform((0.2, -0.1), (0.4, 0.1)), rng.uniform(-np.pi, np.pi)
        elevation, azimuth = np.radians(rng.uniform(60, 90)), rng.uniform(-np.pi, np.pi)
        flat = np.cos(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])
        eye = (*at, 1.0) + 0.65 * np.append(flat, np.sin(elevation))
        target = (*(at + rng.uniform(-0.05, 0.05, 2)), 1.0)
        cell.move("tag_5", lying(at, yaw))
        cell.move("camera", looking_at(eye, target))
        found.append((camera.expose(np.random.default_rng(0)), at, yaw, eye))
    return found


def errors(number, height=None):
    """Give errors across the view [mm] and of the yaw [degrees] at random poses."""
    for frame, at, yaw, eye in tags_seen(number):
        (seen,) = detect_tags(frame, 0.032, height)
        off = seen.T_wt.translation - (*at, 1.0)
        view = ((*at, 1.0) - eye) / 0.65
        across = np.linalg.norm(off if height is not None else off - (off @ view) * view)
        turn = np.arctan2(seen.T_wt.rotation[1, 0], seen.T_wt.rotation[0, 0]) - yaw
        yield 1e3 * across, np.degrees(abs(np.angle(np.exp(1j * turn))))


@pytest.mark.parametrize("number", [5, pytest.param(25, marks=pytest.mark.soak)])
@pytest.mark.parametrize("height", [None, 1.0])
def test_tags_are_accurate(library, opengl, height, number):
    across, yaw = np.array(list(errors(number, height))).T
    for name, values in (("across [mm]", across), ("yaw [deg]", yaw)):
        print(height, name, *np.round(np.percentile(values, (50, 95)), 3))
    assert np.median(across) < (0.1 if number == 25 else 0.15)
    assert np.median(yaw) < (0.2 if number == 25 else 0.3)


def test_without_the_library_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pupil_apriltags", None)
    with pytest.raises(BtManipError, match=r"pip install 'bt-manip-camera\[tags\]'"):
        tag_detector.__wrapped__()
