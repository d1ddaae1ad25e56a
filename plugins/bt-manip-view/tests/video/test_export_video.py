"""A video of a recording shows what was recorded."""

import numpy as np
import pytest

from bt_manip.cell import FrameRenderer, camera_number
from bt_manip_recording import RecordedScene
from bt_manip_view import VideoRecorder, write_video
from bt_manip_view.video.export_video import SceneModel, frame_times
from tests.support.recorded import coming_and_going
from tests.support.recorded import recorded as recorded

from .test_video import frames_of


@pytest.fixture(scope="module")
def videos(opengl, recorded, make_run):
    """Render the recording, and the same run while it goes on."""
    recording, folder, _ = recorded
    exported, live = folder / "exported.mp4", folder / "live.mp4"
    write_video(recording, exported, size="160x100", fps=4.0)
    make_run(coming_and_going()).execute([VideoRecorder(live, size="160x100", fps=4.0)])
    return exported, live


def test_a_rendered_recording_looks_like_the_run(videos):
    (times, images), (live_times, live) = map(frames_of, videos)
    assert len(times) == len(live_times) >= 3
    np.testing.assert_allclose(times, live_times, rtol=0.0, atol=0.5e-3)
    difference = np.abs(images.astype(int) - live)
    assert difference.mean() < 6.0  # textures are their mean colours
    changed = np.abs(live[-1].astype(int) - live[0]).max(axis=2) > 40
    assert changed.mean() > 0.01 and difference[-1][changed].mean() < 20.0


def test_an_object_is_shown_only_while_it_is_there(recorded, opengl):
    recording, _, cube = recorded
    there = [time for time, position in cube.ticks if position is not None]
    scene = RecordedScene(recording)
    shown = SceneModel(scene)
    renderer = FrameRenderer(shown.model, 64, 48, shadow_size=0, samples=0)
    images, alphas = [], []
    for time in (0.0, there[0], cube.ticks[-1][0]):
        scene.seek(time)
        shown.update()
        images.append(renderer.frame(shown.data, camera_number(shown.model, "panda/wrist")))
        alphas.append((shown.model.geom_rgba[:, 3] > 0).sum())
    renderer.close()
    changed = np.abs(images[1].astype(int) - images[0]).max(axis=2) > 20
    assert 0.002 < changed.mean() < 0.1  # the arm has hardly moved
    assert alphas[0] == alphas[2] < alphas[1]


def test_frames_are_at_ticks(recorded):
    recording, _, _ = recorded
    scene = RecordedScene(recording)
    assert frame_times(scene.times, 400.0).tolist() == scene.times.tolist()
    times = frame_times(scene.times, 25.0)
    assert times[-1] <= scene.times[-1] < times[-1] + 0.04
    np.testing.assert_allclose(times, 0.04 * np.arange(len(times)))
    assert frame_times(np.array([0.0, 0.01, 1e10]), 25.0).tolist() == [0.0, 0.01, 1e10]
