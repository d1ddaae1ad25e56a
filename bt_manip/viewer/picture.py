"""Offscreen rendering of a cell."""

import numpy as np

from bt_manip.cell import Cell, FrameRenderer, camera_number
from bt_manip.cell import NoOpenGLError as NoOpenGLError


def render(
    cell: Cell, camera: str = "overview", *, width: int = 1280, height: int = 800
) -> np.ndarray:
    """Return an image of a camera of the cell; the cell does not change.

    Args:
        cell: The cell.
        camera: Full name of a camera in it.
        width: Of the picture, up to 1920 in the project's own arena [pixels].
        height: Of the picture, up to 1200 there [pixels].

    Returns:
        Red, green and blue from 0 to 255, the top row first.  # (height, width, 3)

    Raises:
        BtManipError: If there is no such camera, or the size is too large.
        NoOpenGLError: If no OpenGL backend works.
    """
    number = camera_number(cell.model, camera)
    renderer = FrameRenderer(cell.model, width, height)
    try:
        return renderer.frame(cell.data, number)
    finally:
        renderer.close()
