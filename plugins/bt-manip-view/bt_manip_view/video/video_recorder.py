"""Videos of a run: H.264 in MP4, or animated GIFs."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from bt_manip.bt import NodeStatus
from bt_manip.cell import FrameRenderer, camera_number, parse_size
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import Parameter
from bt_manip.record import RecordingError, check_exists, open_output, writing
from bt_manip.runner import Run, RunObserver

SHADOW_SIZE = 2048
"""Edge length of the shadow map of videos [pixels]: a quarter of the arena's, twice as fast."""

PIXEL_SAMPLES = 4
"""Samples per pixel of videos, which smooth edges."""

GIF_BLOCK = 64
"""Frames of a GIF that share a palette; they are in memory until it is known."""

MP4 = {
    "movflags": "frag_keyframe+empty_moov+default_base_moof",
    "flush_packets": "1",
    "fflags": "+bitexact",
}
"""Options of FFmpeg: fragments, which players show although the end of the file is missing."""

H264 = {"crf": "20", "preset": "fast", "tune": "zerolatency", "threads": "1"}
"""Options of x264: no frames are held back, and the number of cores does not change the file."""

FRAGMENT = 0.5
"""Simulated time in a fragment of an MP4 file: a killed run loses at most this [s]."""


class VideoFile:
    """Writes images as the frames of a video, each with its time.

    When the disk is full, nothing more is written, and `close` raises.

    Args:
        path: The file; its suffix chooses the format.
        width: Width of the images [pixels].
        height: Their height [pixels].
        fps: Usual number of frames per second.

    Raises:
        RecordingError: If it cannot be written.
    """

    suffixes: ClassVar = (".mp4", ".gif")

    def __init__(self, path: Path, width: int, height: int, fps: float) -> None:
        from fractions import Fraction

        import av

        self._path, self._av = path, av
        self._is_gif = path.suffix == ".gif"
        self._error: RecordingError | None = None
        self._block: list[Any] = []
        rate = Fraction(fps).limit_denominator(1000)
        with writing(path, "video"):
            self._file = open_output(path)
        if self._is_gif:
            self._time_base = Fraction(1, 100)
            self._container = av.open(self._file, "w", format="gif", options={"loop": "0"})
            self._stream: Any = self._container.add_stream("gif", rate=rate)
            self._stream.pix_fmt = "pal8"
        else:
            self._time_base = Fraction(1, 1_000_000)
            self._container = av.open(self._file, "w", format="mp4", options=MP4)
            self._stream = self._container.add_stream("libx264", rate=rate, options=H264)
            self._stream.pix_fmt = "yuv420p"
            self._stream.codec_context.gop_size = max(1, round(FRAGMENT * fps))
        self._stream.width, self._stream.height = width, height
        self._stream.codec_context.time_base = self._time_base

    def add(self, time: float, pixels: np.ndarray) -> None:
        """Add a frame.

        Args:
            time: Time from the beginning of the video [s]; a GIF counts in 0.01 s.
            pixels: Red, green and blue from 0 to 255, the top row first.  # (height, width, 3)
        """
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")
        frame.pts, frame.time_base = round(time / self._time_base), self._time_base
        if not self._is_gif:
            self._try(lambda: self._encode([frame]))
        else:
            self._block.append(frame)
            if len(self._block) == GIF_BLOCK:
                self._try(self._encode_block)

    def close(self) -> None:
        """Write the end of the file.

        Raises:
            RecordingError: If the file could not be written, now or before, or was deleted.
        """
        if self._block:
            self._try(self._encode_block)
        self._try(lambda: self._encode([None]))
        self._try(self._container.close)
        self._try(lambda: check_exists(self._file))
        self._file.close()
        if self._error is not None:
            raise self._error

    def _try(self, write: Callable[[], None]) -> None:
        if self._error is None:
            try:
                with writing(self._path, "video"):  # errors of FFmpeg are derived from OSError
                    write()
            except RecordingError as error:
                self._error = error

    def _encode(self, frames: Iterable[Any]) -> None:
        for frame in frames:
            for packet in self._stream.encode(frame):
                self._container.mux(packet)

    def _encode_block(self) -> None:
        """Encode the frames of a GIF so far, with the palette that suits them best."""
        block, self._block = self._block, []
        graph = self._av.filter.Graph()
        first = block[0]
        source = graph.add_buffer(
            width=first.width, height=first.height, format=first.format, time_base=self._time_base
        )
        split, sink = graph.add("split"), graph.add("buffersink")
        palette = graph.add("palettegen", "stats_mode=full")
        use = graph.add("paletteuse", "dither=none:diff_mode=rectangle")
        source.link_to(split)
        split.link_to(palette, 0, 0)
        palette.link_to(use, 0, 1)
        split.link_to(use, 1, 0)
        use.link_to(sink)
        graph.configure()
        for frame in (*block, None):
            graph.push(frame)
        self._encode(graph.pull() for _ in block)


class VideoRecorder(RunObserver):
    """Write a video of a camera: H.264 in a .mp4 file, or an animated .gif.

    Frames are stamped with simulated time; the run is not slowed down to it. Unless ``overlay=no``,
    they show this time and the running leaves of the tree.

    Args:
        path: The file to write.
        camera: Full name of a camera of the cell.
        size: Width and height [pixels], both even: ``1280x720``.
        fps: Frames per simulated second.
        overlay: Whether to show the time and the running leaves.

    Raises:
        BtManipError: If a parameter is impossible, or the path is missing.
    """

    suffix: ClassVar = VideoFile.suffixes

    def __init__(  # noqa: D417 (options are declared in their annotations)
        self,
        path: Path | None,
        *,
        camera: Annotated[str, Parameter("Full name of a camera of the cell")] = "overview",
        size: Annotated[str, Parameter("Width and height, both even", "pixels")] = "1280x720",
        fps: Annotated[float, Parameter("Frames per simulated second", "Hz", above=0.0)] = 25.0,
        overlay: Annotated[bool, Parameter("Whether to show time and running leaves")] = True,
    ) -> None:
        self._path, self._size = check_video(path, size, fps)
        self._camera, self._fps, self._overlay = camera, fps, overlay
        self._renderer: FrameRenderer | None = None
        self._file: VideoFile | None = None
        self._frames = 0

    def check(self, run: Run) -> None:
        """Check that there is the camera, and that it can be rendered.

        Raises:
            BtManipError: If not.
        """
        model = run.station.cell.model
        if self._renderer is None or self._renderer.model is not model:
            self._number = camera_number(model, self._camera)
            self._close_renderer()
            self._renderer = FrameRenderer(
                model, *self._size, shadow_size=SHADOW_SIZE, samples=PIXEL_SAMPLES
            )

    def run_started(self, run: Run) -> None:
        """Open the file."""
        self._run, self._cell = run, run.station.cell
        self._start = self._cell.time
        self._file = VideoFile(self._path, *self._size, self._fps)
        self._due = self._start

    def after_compile(self) -> None:
        """Render the new model; without the camera, there are no frames."""
        try:
            self.check(self._run)
        except BtManipError:
            self._close_renderer()

    def cycle_started(self, cycle: int) -> None:
        """Add the first frame."""
        if not self._frames:
            self._add_frame()

    def after_step(self) -> None:
        """Add a frame when it is due."""
        if self._cell.time >= self._due:
            self._add_frame()

    def run_ended(self) -> None:
        """Close the file."""
        self._close_renderer()
        if self._file is not None:
            self._file.close()

    def _add_frame(self) -> None:
        self._frames += 1
        half_step = 0.5 * self._cell.model.opt.timestep
        self._due = self._start + self._frames / self._fps - half_step
        if self._renderer is None or self._file is None:
            return
        time, running = self._cell.time, NodeStatus.RUNNING
        leaves = [node for node in self._run.tree.nodes if not node.children]
        names = [leaf.name for leaf in leaves if leaf.engine_status is running]
        text = overlay_text(time, names) if self._overlay else ""
        pixels = self._renderer.frame(self._cell.data, self._number, text)
        self._file.add(time - self._start, pixels)

    def _close_renderer(self) -> None:
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


def check_video(path: Path | None, size: str, fps: float) -> tuple[Path, tuple[int, int]]:
    """Return path and size of a video, as `VideoRecorder` takes them.

    Raises:
        BtManipError: If the path is missing, or a parameter is impossible.
    """
    known = " or ".join(VideoFile.suffixes)
    if path is None:
        raise BtManipError("a video needs a file to be written to: --record FILE.mp4")
    if path.suffix not in VideoFile.suffixes:
        raise BtManipError(f"a video is a {known} file, got '{path}'")
    most = 50 if path.suffix == ".gif" else 1000
    if not 0 < fps <= most:
        raise BtManipError(f"a {path.suffix} has up to {most} frames per second, got {fps:g}")
    width, height = parse_size(size)
    if path.suffix == ".mp4" and (width % 2 or height % 2):
        raise BtManipError(f"width and height of a .mp4 video are even, got {size}")
    return path, (width, height)


def overlay_text(time: float, leaves: Iterable[str]) -> str:
    """Return the text over a frame: simulated time [s], and the names of the running leaves."""
    lines = [f"{time:.2f} s", *(f"{name}  RUNNING" for name in leaves)]
    return "\n".join(lines).encode("ascii", "replace").decode()  # MuJoCo's font has no others
