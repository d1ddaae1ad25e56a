"""Offscreen rendering of a cell."""

import os

import mujoco
import numpy as np

from bt_manip.cell import Cell
from bt_manip.exceptions import BtManipError, did_you_mean


class NoOpenGLError(BtManipError):
    """No OpenGL backend works."""


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
    model = cell.model
    cameras = [model.camera(i).name for i in range(model.ncam)]
    if camera not in cameras:
        raise BtManipError(f"there is no camera '{camera}'{did_you_mean(camera, cameras)}")
    most = (model.vis.global_.offwidth, model.vis.global_.offheight)
    if not (0 < width <= most[0] and 0 < height <= most[1]):
        raise BtManipError(
            f"a picture of this cell has up to {most[0]} x {most[1]} pixels, got {width} x {height}"
        )
    # After a step, poses of bodies are those of its start: update them in a copy.
    data = mujoco.MjData(model)
    mujoco.mj_copyData(data, model, cell.data)
    mujoco.mj_forward(model, data)
    with _renderer(model, width, height) as renderer:
        renderer.update_scene(data, camera)
        return renderer.render()


def _renderer(model: mujoco.MjModel, width: int, height: int) -> mujoco.Renderer:
    try:
        return mujoco.Renderer(model, height, width)
    except Exception as error:  # each backend raises an error of its own
        text = " ".join(str(error).split()) or type(error).__name__
        backend = os.environ.get("MUJOCO_GL") or "unset"
        raise NoOpenGLError(
            f"nothing can be drawn with MUJOCO_GL {backend} ({text}); without a display, "
            "MUJOCO_GL=egl or MUJOCO_GL=osmesa draws where one of them is installed"
        ) from error
