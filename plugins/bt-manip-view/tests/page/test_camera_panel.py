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
from bt_manip.runner import RunObserver
from bt_manip_view.page import camera_panel
from bt_manip_view.page.camera_panel import NO_CAMERA, PICTURE_SIZE


def root():
    return Sequence("root", SpawnObject(object="{cube}"), Sleep(msec=200))


class Chooser(RunObserver):
    """Chooses a camera before the first tick."""

    def __init__(self, page, client, camera):
        self.page, self.client, self.camera = page, client, camera

    def run_started(self, run):
        self.cell = run.station.cell
        self.page.refresh(now=True)
        self.client.see().send(self.client.uid("dropdown", "Camera"), "value", self.camera)


@pytest.fixture
def picture(page, connect):
    """Give a function that returns the picture of a browser, and its text about the camera."""
    client = connect("page")

    def see():
        element = client.see().find("picture")
        shown = None
        if element["visible"]:
            data = base64.b64decode(element["source"].partition(",")[2])
            shown = np.asarray(Image.open(io.BytesIO(data)))
        text = next(
            one["content"]
            for one in client.elements.values()
            if one["kind"] == "html" and one["parent"] == element["parent"]
        )
        return shown, text

    see.client = client
    return see


def test_the_picture_is_that_of_the_chosen_camera_and_does_not_change_the_run(
    opengl, make_run, page, picture, monkeypatch
):
    def digest(*observers):
        recorder = Recorder("test", 0)
        make_run(root()).execute([recorder, page, *observers])
        return recorder.report().state_digest

    monkeypatch.setattr(camera_panel, "PICTURE_SHARE", 1e9)
    monkeypatch.setattr(camera_panel, "PICTURE_PERIOD", 0.0)
    with monkeypatch.context() as without_renderer:
        without_renderer.setattr(camera_panel, "FrameRenderer", None)
        expected_digest = digest(Chooser(page, picture.client, NO_CAMERA))
        assert picture() == (None, "")
    chooser = Chooser(page, picture.client, "panda/wrist")
    assert digest(chooser) == expected_digest
    shown, text = picture()
    cell = chooser.cell
    with FrameRenderer(cell.model, *PICTURE_SIZE, shadow_size=0, samples=0) as renderer:
        expected = renderer.frame(cell.data, camera_number(cell.model, "panda/wrist"))
    assert not text
    assert np.abs(shown.astype(int) - expected).mean() < 4.0  # of JPEG


def test_without_opengl_a_line_says_so_and_the_run_goes_on(make_run, page, picture, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "disable")
    make_run(root()).execute([page, Chooser(page, picture.client, "panda/wrist")])
    shown, text = picture()
    assert shown is None and "nothing can be drawn with MUJOCO_GL disable" in text
    assert picture.client.find("dropdown", "Camera")["value"] == NO_CAMERA
