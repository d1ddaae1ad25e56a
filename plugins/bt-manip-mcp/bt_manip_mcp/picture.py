"""A recorder that draws the cell as a run leaves it: at the moment of its failure, if it fails."""

from pathlib import Path
from typing import Annotated

from bt_manip.cell import FrameRenderer, camera_number
from bt_manip.parameters import Parameter
from bt_manip.record import writing
from bt_manip.runner import Run, RunObserver

SIZE = (800, 600)
"""Width and height of the picture [pixels]."""


class PictureRecorder(RunObserver):
    """Draw the end of a run as a PNG.

    Args:
        path: The file; None: ``end.png``.
        cameras: Full name of the camera.
    """

    suffix = ".png"

    def __init__(
        self,
        path: Path | None,
        *,
        cameras: Annotated[str, Parameter("Full name of the camera.")] = "overview",
    ) -> None:
        self._path, self._camera = path or Path("end.png"), cameras

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
        with FrameRenderer(cell.model, *SIZE) as renderer:
            pixels = renderer.frame(cell.data, camera_number(cell.model, self._camera))
        with writing(self._path, "picture"):
            Image.fromarray(pixels).save(self._path)
