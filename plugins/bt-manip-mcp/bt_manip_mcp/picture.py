"""A recorder that draws the cell as a run leaves it: at the moment of its failure, if it fails."""

from pathlib import Path
from typing import Annotated

from bt_manip.cell import FrameRenderer, camera_number
from bt_manip.parameters import Parameter
from bt_manip.record import writing
from bt_manip.runner import Run, RunObserver


class PictureRecorder(RunObserver):
    """Draw the end of a run as a PNG.

    Args:
        path: The file; None: ``end.png``.
        cameras: Full name of the camera.
        width: Width of the picture [pixels].
        height: Height of the picture [pixels].
    """

    suffix = ".png"

    def __init__(
        self,
        path: Path | None,
        *,
        cameras: Annotated[str, Parameter("Full name of the camera.")] = "overview",
        width: Annotated[int, Parameter("Width [pixels].", at_least=16, at_most=1920)] = 800,
        height: Annotated[int, Parameter("Height [pixels].", at_least=16, at_most=1200)] = 600,
    ) -> None:
        self._path = path or Path("end.png")
        self._camera, self._width, self._height = cameras, width, height

    def run_started(self, run: Run) -> None:
        """Keep the cell."""
        self._cell = run.station.cell

    def run_ended(self) -> None:
        """Draw it.

        Raises:
            NoOpenGLError: If no OpenGL backend works.
            RecordingError: If the file cannot be written.
        """
        from PIL import Image

        cell = self._cell
        renderer = FrameRenderer(cell.model, self._width, self._height)
        try:
            pixels = renderer.frame(cell.data, camera_number(cell.model, self._camera))
        finally:
            renderer.close()
        with writing(self._path, "picture"):
            Image.fromarray(pixels).save(self._path)
