"""Images of cameras in a recording."""

from collections.abc import Sequence
from contextlib import nullcontext, suppress
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.cell import CellError, FrameRenderer, camera_number
from bt_manip.exceptions import BtManipError

if TYPE_CHECKING:
    from bt_manip_recording.mcap_file import McapFile

IMAGE_TOPICS = "/images/"
"""Beginning of the topics of images."""

JPEG = {"qmin": "3", "qmax": "3"}
"""Options of FFmpeg's encoder: a quality of about 90 of 100."""


class CameraImages:
    """Adds JPEG images of some cameras to a recording, as ``foxglove.CompressedImage``.

    They are rendered without shadows, reflections and anti-aliasing, ten times as fast.

    Args:
        cameras: Their full names.
        size: Width and height of the images [pixels].
        fps: Images per simulated second; an image is of the first tick at which it is due.

    Raises:
        BtManipError: If the rate is not above 0.
    """

    def __init__(self, cameras: Sequence[str], size: tuple[int, int], fps: float) -> None:
        if not fps > 0.0:
            raise BtManipError(f"image_fps is above 0, got {fps:g}")
        self._cameras, self._size, self._fps = cameras, size, fps
        self._renderer: FrameRenderer | None = None
        self._due = -np.inf  # [s]

    def bind(self, cell: Any, *, first: bool = False) -> None:
        """Bind to the compiled model of a cell.

        Args:
            cell: The `bt_manip.cell.Cell`.
            first: Whether all cameras must be there.

        Raises:
            BtManipError: If the first model has no such camera, or it cannot be rendered.
        """
        model, self._data = cell.model, cell.data
        self._numbers: dict[str, int] = {}
        for name in self._cameras:
            with nullcontext() if first else suppress(CellError):
                self._numbers[name] = camera_number(model, name)
        if self._renderer is None or self._renderer.model is not model:
            self.close()
            self._renderer = FrameRenderer(model, *self._size, shadow_size=0, samples=0)

    def write(self, file: "McapFile", nanoseconds: int) -> None:
        """Add the present images if they are due.

        Args:
            file: The recording.
            nanoseconds: Simulated time [ns].
        """
        from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

        from bt_manip_recording.foxglove import timestamp_of

        time = nanoseconds / 1e9
        if self._renderer is None or time < self._due - 1e-6:
            return
        self._due = max(self._due, time) + 1.0 / self._fps
        for name, number in self._numbers.items():
            image = CompressedImage(
                timestamp=timestamp_of(nanoseconds),
                frame_id=name,
                format="jpeg",
                data=jpeg(self._renderer.frame(self._data, number)),
            )
            file.add_topic(IMAGE_TOPICS + name, CompressedImage)
            file.add(IMAGE_TOPICS + name, nanoseconds, image.SerializeToString())

    def close(self) -> None:
        """Free the OpenGL context."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


def jpeg(pixels: np.ndarray) -> bytes:
    """Encode an image as JPEG.

    Args:
        pixels: Red, green and blue from 0 to 255, the top row first.  # (height, width, 3) uint8
    """
    import av

    height, width, _ = pixels.shape
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")
    return b"".join(map(bytes, _encoder(width, height).encode(frame)))


@lru_cache(4)
def _encoder(width: int, height: int) -> Any:
    import av

    encoder: Any = av.CodecContext.create("mjpeg", "w")
    encoder.width, encoder.height = width, height
    encoder.pix_fmt, encoder.time_base = "yuvj420p", Fraction(1, 1000)
    encoder.options, encoder.thread_count = JPEG, 1
    return encoder
