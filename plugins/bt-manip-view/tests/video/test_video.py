"""A video shows the camera's images at their simulated times, and plays after a kill."""

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import av
import mujoco
import numpy as np
import pytest

from bt_manip.behaviours import MoveToConfiguration
from bt_manip.bt import Sleep
from bt_manip.exceptions import BtManipError
from bt_manip.record import RecordingError
from bt_manip.runner import RunObserver
from bt_manip.viewer import NoOpenGLError, render
from bt_manip_view import VideoRecorder
from bt_manip_view.video.video_recorder import VideoFile

WIDTH, HEIGHT = 160, 100
SIZE = f"{WIDTH}x{HEIGHT}"
TARGET = [0.4, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]


class Ends(RunObserver):
    """Keeps pictures of the first and the last state."""

    def run_started(self, run):
        self.run, self.cell = run, run.station.cell

    def cycle_started(self, cycle):
        self.first = render(self.cell, width=WIDTH, height=HEIGHT)

    def run_ended(self):
        self.last = render(self.cell, width=WIDTH, height=HEIGHT)


@pytest.fixture(scope="module")
def videos(opengl, make_run, tmp_path_factory):
    """Record a motion by the overview, with text, and by the wrist as a GIF; give all."""
    folder = tmp_path_factory.mktemp("videos")
    files = [folder / name for name in ("plain.mp4", "text.mp4", "wrist.gif")]
    ends = Ends()
    make_run(MoveToConfiguration("turn", configuration=TARGET)).execute([
        ends,
        VideoRecorder(files[0], size=SIZE, fps=10.0, overlay=False),
        VideoRecorder(files[1], size=SIZE, fps=4.0),
        VideoRecorder(
            files[2], size="80x51", fps=5.0, camera="panda/wrist", overlay=False
        ),
    ])  # fmt: skip
    return files, ends


def frames_of(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Give the times of the frames and their images."""
    with av.open(path) as video:
        frames = list(video.decode(video=0))
    times = [float(frame.pts * frame.time_base) for frame in frames]
    return np.array(times), np.array([frame.to_ndarray(format="rgb24") for frame in frames])


def test_each_frame_is_at_its_simulated_time(videos):
    files, ends = videos
    for path, fps in zip(files, (10, 4, 5), strict=True):
        times, _ = frames_of(path)
        assert len(times) == int(ends.cell.time * fps) + 1
        np.testing.assert_allclose(times, np.arange(len(times)) / fps, rtol=0.0, atol=0.5001e-3)
    # Control steps are 1 ms apart, and frames are not between them.
    times, _ = frames_of(files[0])
    np.testing.assert_allclose(times, times.round(3), rtol=0.0, atol=1e-9)


def test_the_format_is_what_browsers_play(videos):
    with av.open(videos[0][0]) as video:
        stream = video.streams.video[0]
        assert (stream.codec_context.name, stream.pix_fmt) == ("h264", "yuv420p")
        assert (stream.width, stream.height) == (WIDTH, HEIGHT)
        assert float(stream.average_rate) == pytest.approx(10, rel=0.01)


def test_the_frames_are_the_images_of_the_camera(videos):
    files, ends = videos
    times, images = frames_of(files[0])
    assert ends.cell.time - times[-1] < 1 / 10
    for image, expected in zip(images[[0, -1]].astype(int), (ends.first, ends.last), strict=True):
        assert np.abs(image - expected).mean() < 6.0
        # The same share is as white as only the robot is.
        white = [(pixels.min(axis=2) > 225).mean() for pixels in (image, expected)]
        assert white[0] == pytest.approx(white[1], abs=0.002) and white[1] > 0.005


def test_a_gif_shows_its_camera(videos):
    with av.open(videos[0][2]) as video:
        assert video.format.name == "gif"
        assert (video.streams.video[0].width, video.streams.video[0].height) == (80, 51)
    _, images = frames_of(videos[0][2])
    assert np.unique(images[0].reshape(-1, 3), axis=0).shape[0] > 20


def test_the_overlay_covers_the_corner_and_changes_with_the_time(videos):
    (plain, text, _), _ = videos
    (_, with_text), (_, without) = frames_of(text), frames_of(plain)
    difference = np.abs(with_text[0].astype(int) - without[0]).max(axis=2) > 60
    rows, columns = np.nonzero(difference)
    assert difference.mean() > 0.02 and columns.min() < 10 and rows.max() < HEIGHT / 2
    corner = with_text[:, :20, :60].astype(int)
    assert (np.abs(corner[-1] - corner[0]).max(axis=2) > 60).any()


def test_a_video_does_not_change_the_run(videos, make_run):
    _, ends = videos
    unseen = make_run(MoveToConfiguration("turn", configuration=TARGET))
    unseen.execute()
    assert ends.cell.state_bytes() == unseen.station.cell.state_bytes()


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_the_same_frames_give_the_same_bytes(suffix, tmp_path):
    images = np.random.default_rng(1).integers(0, 256, (3, 32, 48, 3), dtype=np.uint8)
    files = [tmp_path / f"{i}{suffix}" for i in range(2)]
    for path in files:
        video = VideoFile(path, 48, 32, 10.0)
        for i, image in enumerate(images):
            video.add(i / 10, image)
        video.close()
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_long_gif_has_several_palettes(tmp_path):
    video = VideoFile(tmp_path / "long.gif", 16, 16, 20.0)
    shades = [(3 * i, 255 - 3 * i, 40) for i in range(70)]
    for i, shade in enumerate(shades):
        video.add(i / 20, np.full((16, 16, 3), shade, dtype=np.uint8))
    video.close()
    times, images = frames_of(tmp_path / "long.gif")
    np.testing.assert_allclose(times, np.arange(70) / 20, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(images[:, 8, 8], shades, rtol=0.0, atol=6)


def test_a_killed_run_leaves_what_plays(tmp_path):
    path = tmp_path / "cut.mp4"
    code = f"""
        import os, signal, numpy, pathlib
        from bt_manip_view.video.video_recorder import VideoFile
        video = VideoFile(pathlib.Path({str(path)!r}), 64, 48, 25.0)
        for i in range(80):
            video.add(i / 25, numpy.full((48, 64, 3), 3 * i, dtype=numpy.uint8))
        os.kill(os.getpid(), signal.SIGKILL)
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], env=os.environ)
    assert done.returncode == -signal.SIGKILL
    times, images = frames_of(path)
    assert 80 - 25 * 0.6 <= len(times) <= 80
    np.testing.assert_allclose(images[:, 24, 32, 1], 3 * np.arange(len(times)), atol=8)


def test_a_full_disk_is_one_error_at_the_end():
    path = Path("/dev/full")
    video = VideoFile(path, 64, 48, 25.0)
    for i in range(60):
        video.add(i / 25, np.zeros((48, 64, 3), dtype=np.uint8))
    with pytest.raises(RecordingError, match="video '/dev/full' cannot be written: No space left"):
        video.close()


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        (None, {}, "--record FILE.mp4"),
        ("a.avi", {}, "a video is a .mp4 or .gif file, got 'a.avi'"),
        ("a.mp4", {"size": "641x400"}, "width and height of a .mp4 video are even, got 641x400"),
        ("a.mp4", {"size": "large"}, "size is WIDTHxHEIGHT, such as 640x400, got 'large'"),
        ("a.mp4", {"fps": 0.0}, "up to 1000 frames per second, got 0"),
        ("a.gif", {"fps": 60.0}, "a .gif has up to 50 frames per second, got 60"),
    ],
)
def test_an_impossible_video_is_refused(name, options, message):
    with pytest.raises(BtManipError) as error:
        VideoRecorder(name and Path(name), **options)
    assert message in str(error.value)


def test_without_opengl_the_run_does_not_start(make_run, tmp_path, monkeypatch):
    def fail(*_):
        raise mujoco.FatalError("no context")

    monkeypatch.setattr(mujoco.Renderer, "__init__", fail)
    with pytest.raises(NoOpenGLError, match="MUJOCO_GL=egl"):
        make_run(Sleep(msec=20)).execute([VideoRecorder(tmp_path / "a.mp4")])
