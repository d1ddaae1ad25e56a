"""The camera image over the scene shows the cell, a few times a second."""

import base64
import io

import numpy as np
import pytest
from PIL import Image

from bt_manip.behaviours import SpawnObject
from bt_manip.bt import Sequence, Sleep
from bt_manip.cell import FrameRenderer, camera_number
from bt_manip.record import Recorder
from bt_manip_view.page import camera_panel
from bt_manip_view.page.camera_panel import NO_CAMERA, PICTURE_SIZE


@pytest.fixture
def execute(make_run, page, client):
    """Execute a run in which a camera is chosen; return its cell and the digest of its state."""

    def execute(camera):
        run = make_run(Sequence("root", SpawnObject(object="{cube}"), Sleep(msec=200)))
        recorder = Recorder("test", 0)
        page.begin_idle(run.station)
        client.set("dropdown", "Camera", camera)
        run.execute([recorder, page])
        return run.station.cell, recorder.report().state_digest

    return execute


def test_the_picture_is_that_of_the_chosen_camera_and_does_not_change_the_run(
    opengl, client, execute, monkeypatch
):
    monkeypatch.setattr(camera_panel, "PICTURE_SHARE", 1e9)
    monkeypatch.setattr(camera_panel, "PICTURE_PERIOD", 0.0)
    with monkeypatch.context() as without_renderer:
        without_renderer.setattr(camera_panel, "FrameRenderer", None)
        _, expected_digest = execute(NO_CAMERA)
        assert not client.see().find("picture")["visible"]
    cell, digest = execute("panda/wrist")
    assert digest == expected_digest
    picture = client.see().find("picture")
    data = base64.b64decode(picture["source"].partition(",")[2])
    shown = np.asarray(Image.open(io.BytesIO(data))).astype(int)
    with FrameRenderer(cell.model, *PICTURE_SIZE, shadow_size=0, samples=0) as renderer:
        expected = renderer.frame(cell.data, camera_number(cell.model, "panda/wrist"))
    assert picture["visible"] and np.abs(shown - expected).mean() < 4.0  # of JPEG


def test_without_opengl_a_line_says_so_and_the_run_goes_on(client, execute, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    execute("panda/wrist")
    assert "nothing can be drawn with MUJOCO_GL disable" in client.text()
    assert not client.find("picture")["visible"]
    assert client.find("dropdown", "Camera")["value"] == NO_CAMERA
