"""Camera image over the scene."""

import base64
import io
import time
from typing import Any

from bt_manip.cell import FrameRenderer, camera_number
from bt_manip.exceptions import BtManipError
from bt_manip.runner import Run, Station

from .panel import Panel, message_html

NO_CAMERA = "none"
"""Option for no camera."""

PICTURE_SIZE = (320, 200)
"""Width and height of the image [pixels]."""

PICTURE_PERIOD = 0.25
"""Wall time between two images [s]."""

PICTURE_SHARE = 0.05
"""Largest share of wall time spent on rendering; slow rendering lowers the rate."""

LONGEST_WAIT = 2.0
"""Longest wall time between two images [s]."""


class CameraPanel(Panel):
    """Renders the selected camera between two ticks, while any browser shows the page.

    The OpenGL context belongs to the thread of the run.
    """

    place = "over"
    needs_run = True

    def __init__(self, page: Any) -> None:
        self._page = page
        hint = "Shows the image of a camera, a few times a second"
        self._choice = page.gui.add_dropdown("Camera", (NO_CAMERA,), hint=hint)
        self._picture = page.gui.add("picture", source="", visible=False)
        self._message = page.gui.add_html("")
        self._renderer: FrameRenderer | None = None
        self._shown = NO_CAMERA
        self._cell: Any = None
        self._model: Any = None  # whose cameras are offered
        self._next = 0.0

    def start(self, run: Run) -> None:
        """Offer the cameras of the run's cell."""
        self._cell = run.station.cell

    def begin_idle(self, station: Station) -> None:
        """Offer the cameras of the cell between runs."""
        self._cell = station.cell

    def end_tick(self) -> None:
        """Render the next image if it is due."""
        if self._choice.value == NO_CAMERA or not self._page.is_open:
            self.close()
        elif (before := time.perf_counter()) >= self._next:
            self._render()
            after = time.perf_counter()
            wait = max(PICTURE_PERIOD, min((after - before) / PICTURE_SHARE, LONGEST_WAIT))
            self._next = before + wait

    def idle_tick(self) -> None:
        """Render the next image between runs if it is due."""
        self.end_tick()

    def draw(self) -> None:
        """Update the list of cameras; render one that was just chosen even if the run is paused."""
        if self._cell is None:
            return
        model = self._cell.model
        if model is not self._model:
            self._model = model
            self._choice.options = (NO_CAMERA, *(model.camera(i).name for i in range(model.ncam)))
        if self._renderer is None or self._shown != self._choice.value:
            self.end_tick()
        self._picture.visible = self._renderer is not None

    def close(self) -> None:
        """Free the OpenGL context."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    # Internal

    def _render(self) -> None:
        from PIL import Image  # not when plugins are loaded

        model = self._cell.model
        self._message.content, self._shown = "", self._choice.value
        try:
            number = camera_number(model, self._shown)
            if self._renderer is None or self._renderer.model is not model:
                self.close()
                self._renderer = FrameRenderer(model, *PICTURE_SIZE, shadow_size=0, samples=0)
            image = Image.fromarray(self._renderer.frame(self._cell.data, number))
        except BtManipError as error:  # the camera was removed, or there is no OpenGL
            self._choice.value = NO_CAMERA
            self._message.content = message_html(str(error), error=True)
            return
        image.save(data := io.BytesIO(), "JPEG")
        self._picture.source = (
            "data:image/jpeg;base64," + base64.b64encode(data.getvalue()).decode()
        )
