"""What cameras see is on the page and in recordings."""

import base64
import io
import json
from contextlib import closing
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from mcap.reader import make_reader
from PIL import Image

from bt_manip.bt import NodeStatus
from bt_manip.runner import RunLoop
from bt_manip_camera.panel import SeenPanel
from bt_manip_recording import McapRecorder
from bt_manip_view import Page

TOP, HALF = 1.015 + 0.07, 0.035
"""Height of the cube's top in the world, and half of its side [m]."""


def until_seen(run, loop):
    loop.begin()
    while "cube" not in run.station.believed.cell.entities:
        assert loop.advance() is NodeStatus.RUNNING


@pytest.fixture
def shown(run, believe_off):
    """Give the panel, and a loop that has just begun; the cube is believed 5 mm off."""
    believe_off(4e-3, 3e-3, 0.0)

    def make(page):
        page.seen = SeenPanel(page)
        return page.seen

    with closing(Page({"seen": make}, port=0, speed=None)) as page, RunLoop(run, [page]) as loop:
        yield page.seen, loop


def test_the_page_lists_what_is_believed_and_outlines_it(run, shown):
    panel, loop = shown
    believed = run.station.believed.cell
    loop.begin()
    panel.draw()
    assert "<td>cube</td>" + 5 * "<td>-</td>" in panel.table.content
    until_seen(run, loop)
    panel.draw()
    place, true = (c.pose("cube").translation for c in (believed, run.station.cell))
    seen, now = run.station.believed.poses.source.seen["cube"], run.station.cell.time
    at = " ".join(f"{1e3 * value:.0f}" for value in place)
    off = 1e3 * np.linalg.norm(place - true)
    values = f"{1e3 * seen.position_error:.1f}", f"{off:.1f}", f"{now - seen.time:.1f}", "eye"
    row = "".join(f"<td>{value}</td>" for value in ("cube", at, *values))
    assert f"<tr>{row}</tr>" in panel.table.content
    outline = panel.outlines["cube"]
    assert outline.name == "/believed/cube"
    np.testing.assert_allclose(outline.position, place)
    sides = np.linalg.norm(np.diff(outline.points, axis=1), axis=2)
    np.testing.assert_allclose(sides, 0.07, rtol=1e-6)  # twelve edges of the cube
    assert sides.shape == (12, 1)
    panel.begin_idle(SimpleNamespace(believed=None, cell=SimpleNamespace(entities={})))
    panel.draw()
    assert not panel.table.visible and not panel.outlines and panel.cloud is None


def test_the_page_has_the_picture_with_outlines_and_the_points_in_the_scene(run, shown):
    panel, loop = shown
    until_seen(run, loop)
    panel.draw()
    svg, note = ElementTree.fromstring(f"<div>{panel.picture.content}</div>")
    image, *shapes = svg
    outlines = {label.text: one for one, label in zip(shapes[::2], shapes[1::2], strict=True)}
    data = base64.b64decode(image.get("href").removeprefix("data:image/jpeg;base64,"))
    assert np.asarray(Image.open(io.BytesIO(data))).shape == (240, 320, 3)
    assert (svg.get("viewBox"), image.get("width"), image.get("height")) == (
        "0 0 320 240", "320", "240"
    )  # fmt: skip
    corners = [point.split(",") for point in outlines["cube"].get("points").split()]
    check_outline(np.array(corners, float), true_outline(run))
    assert note.text.startswith("eye, ")
    assert panel.cloud.name == "/seen"
    check_points(run, panel.cloud.points, panel.cloud.colors)
    panel.points.value = False
    panel.draw()
    assert panel.cloud is None


def true_outline(run):
    """Give where the corners of the top of the cube of the physics are in the picture."""
    model, data = run.station.cell.model, run.station.cell.data
    tool, geom = run.station.robot.tool_site_id, model.geom("cube/box").id
    R = data.site_xmat[tool].reshape(3, 3)
    eye = data.site_xpos[tool] + R @ (0.07, 0.0, -0.06)  # of the scene
    top = data.geom_xpos[geom] + HALF * (
        [(-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1)] @ data.geom_xmat[geom].reshape(3, 3).T
    )
    x, y, z = ((top - eye) @ R).T  # the camera looks along z, with y down
    f = 120.0 / np.tan(np.radians(25.0))
    return np.column_stack([160.0 + f * x / z, 120.0 + f * y / z])


def check_outline(corners, expected):
    """Check that corners are the expected ones, but for errors of the camera [pixels]."""
    gaps = np.linalg.norm(expected[:, None] - corners, axis=2)
    assert gaps.min(axis=1).max() < 2.0, (expected, corners)


def check_points(run, points, colours):
    """Check that points on the cube are at its top in the physics, and as bright as wood."""
    middle = run.station.cell.pose("cube").translation
    top = np.linalg.norm(points[:, :2] - middle[:2], axis=1) < 0.025
    assert top.sum() > 20
    assert np.median(points[top, 2]) == pytest.approx(TOP, abs=5e-3)
    red, _, blue = np.median(colours[top], axis=0)
    assert 255 >= red > blue + 20


def test_a_recording_has_picture_outlines_points_and_beliefs_beside_the_truth(run, tmp_path):
    path = tmp_path / "run.mcap"
    with RunLoop(run, [McapRecorder(path)]) as loop:
        until_seen(run, loop)
        expected = true_outline(run)
        for _ in range(11):
            loop.advance()
        cells = run.station.believed.cell, run.station.cell
        believed, true = (cell.pose("cube").translation for cell in cells)
    last, times = {}, []
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            last[channel.topic] = schema.name, message.data
            times += [message.log_time] if channel.topic == "/believed" else []

    def read(topic, kind):
        name, data = last[topic]
        assert name == kind.DESCRIPTOR.full_name
        return kind.FromString(data)

    image = read("/seen/eye/image", CompressedImage)
    picture = np.asarray(Image.open(io.BytesIO(image.data)))
    assert (picture.shape, image.format) == ((240, 320, 3), "jpeg")
    seen = run.station.believed.poses.source.seen["cube"]
    assert image.timestamp.ToNanoseconds() == pytest.approx(1e9 * seen.time)
    assert len(times) > 3 and np.diff(times) == pytest.approx(1e8)  # [ns]
    drawn = read("/seen/eye/outlines", ImageAnnotations)
    number = [text.text for text in drawn.texts].index("cube")
    check_outline(np.array([(one.x, one.y) for one in drawn.points[number].points]), expected)
    cloud = read("/seen/eye/points", PointCloud)
    kinds = {1: "u1", 7: "<f4"}
    rows = np.frombuffer(cloud.data, {
        "names": [one.name for one in cloud.fields],
        "formats": [kinds[one.type] for one in cloud.fields],
        "offsets": [one.offset for one in cloud.fields],
        "itemsize": cloud.point_stride,
    })  # fmt: skip
    points, colours = (
        np.column_stack([rows[name] for name in names])
        for names in ("xyz", ("red", "green", "blue"))
    )
    check_points(run, points, colours)
    frame = run.station.cell.find("eye").detections.frame
    assert len(rows) == np.count_nonzero(frame.depth[::4, ::4]) and (rows["alpha"] == 255).all()
    cube = json.loads(last["/believed"][1])["cube"]
    np.testing.assert_allclose(cube["position"], believed)
    np.testing.assert_allclose(cube["true_position"], true, atol=1e-6)
    assert cube["off"] == pytest.approx(np.linalg.norm(believed - true), abs=1e-6)
    (box,) = read("/believed/outlines", SceneUpdate).entities
    ends = np.array([(one.x, one.y, one.z) for one in box.lines[0].points])
    assert len(ends) == 24
    np.testing.assert_allclose(ends.mean(axis=0), believed, atol=1e-6)
    np.testing.assert_allclose(
        np.linalg.norm(ends - believed, axis=1), HALF * np.sqrt(3), rtol=1e-5
    )
    layout = json.loads(path.with_suffix(".layout.json").read_text())["configById"]
    shown = {
        "imageTopic": "/seen/eye/image",
        "annotations": {"/seen/eye/outlines": {"visible": True}},
    }
    assert layout["Image!/seen/eye/image"]["imageMode"] == shown
    assert {"/seen/eye/points", "/believed/outlines"} < set(layout["3D!scene"]["topics"])
