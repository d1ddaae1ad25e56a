"""Offscreen rendering of a model."""

import os
import re
import warnings
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from bt_manip.exceptions import BtManipError, did_you_mean

from .exceptions import CellError

if TYPE_CHECKING:
    from .cell import Cell

_DISABLED = ("disable", "disabled", "off", "false", "0")  # values of MUJOCO_GL


class NoOpenGLError(CellError):
    """No OpenGL backend works."""


class FrameRenderer(mujoco.Renderer):
    """Renders the cameras of a model, optionally with text in the image.

    Args:
        width: Width of the images, up to 1920 in bt-manip's arena [pixels].
        height: Height of the images, up to 1200 in bt-manip's arena [pixels].
        shadow_size: Edge length of the shadow map, 0 for no shadows and reflections [pixels]; None:
            the model's.
        samples: Samples per pixel, 0 for hard edges; None: the model's.

    Attributes:
        model: The compiled model.
        failure: Why no OpenGL backend works, of the class: another attempt would abort the process.

    Raises:
        CellError: If the size is zero or too large.
        NoOpenGLError: If no OpenGL backend works.
    """

    failure = ""
    _gl_context: Any = None  # if it could not be opened
    _mjr_context: Any = None

    def __init__(
        self,
        model: mujoco.MjModel,
        width: int,
        height: int,
        *,
        shadow_size: int | None = None,
        samples: int | None = None,
    ) -> None:
        most = (int(model.vis.global_.offwidth), int(model.vis.global_.offheight))
        if not (0 < width <= most[0] and 0 < height <= most[1]):
            raise CellError(
                f"an image of this cell has up to {most[0]} x {most[1]} pixels, "
                f"got {width} x {height}"
            )
        backend = os.environ.get("MUJOCO_GL") or "unset"
        if backend.strip().lower() in _DISABLED:
            raise NoOpenGLError(
                f"nothing can be drawn with MUJOCO_GL {backend}; without a display, MUJOCO_GL=egl "
                "draws where it is installed"
            )
        if FrameRenderer.failure:
            raise NoOpenGLError(FrameRenderer.failure)
        quality = model.vis.quality
        kept = quality.shadowsize, quality.offsamples
        if shadow_size is not None:
            quality.shadowsize = max(shadow_size, 16)  # the minimum of a context
        if samples is not None:
            quality.offsamples = samples
        try:
            with warnings.catch_warnings():  # the error replaces GLFW's warnings
                warnings.simplefilter("ignore")
                super().__init__(model, height, width)
        except Exception as error:  # each backend has its own type of error
            text = " ".join(str(error).split()) or type(error).__name__
            FrameRenderer.failure = (
                f"nothing can be drawn with MUJOCO_GL {backend} ({text}); without a display, "
                "MUJOCO_GL=egl or MUJOCO_GL=osmesa draws where one of them is installed"
            )
            raise NoOpenGLError(FrameRenderer.failure) from error
        finally:
            quality.shadowsize, quality.offsamples = kept
        self._shadows = shadow_size != 0
        self._data = mujoco.MjData(model)

    def show(self, data: mujoco.MjData, camera: int) -> None:
        """Set the scene to a state and a camera.

        Args:
            data: The state, which is not changed; poses of bodies are computed from the joint
                positions, since after a step they are those of its start.
            camera: Number of the camera, see `camera_number`.
        """
        mujoco.mj_copyData(self._data, self.model, data)
        mujoco.mj_fwdPosition(self.model, self._data)
        self.update_scene(self._data, camera)
        if not self._shadows:
            for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
                self.scene.flags[flag] = 0

    def frame(self, data: mujoco.MjData, camera: int, text: str = "") -> np.ndarray:
        """Return an image of a state.

        Args:
            data: The state, as for `show`.
            camera: Number of the camera, see `camera_number`.
            text: Text at the top left.

        Returns:
            Red, green and blue from 0 to 255, the top row first.  # (height, width, 3)
        """
        self.show(data, camera)
        pixels = self.render()
        if text:
            font, corner = mujoco.mjtFont.mjFONT_NORMAL, mujoco.mjtGridPos.mjGRID_TOPLEFT
            mujoco.mjr_overlay(font, corner, self._rect, text, "", self._mjr_context)
            mujoco.mjr_readPixels(pixels, None, self._rect, self._mjr_context)
            pixels = pixels[::-1]
        return pixels

    def depth(self) -> np.ndarray:
        """Return the depth image of the scene: distances along the camera's axis [m]."""
        self.enable_depth_rendering()
        try:
            return self.render()
        finally:
            self.disable_depth_rendering()

    def elements(self) -> np.ndarray:
        """Return id and type of the element shown by each pixel of the scene."""
        self.enable_segmentation_rendering()
        try:
            return self.render()  # (height, width, 2)
        finally:
            self.disable_segmentation_rendering()

    def close(self) -> None:
        """Free the context, made current first, as the base class requires."""
        if self._gl_context is not None:
            with suppress(Exception):  # at interpreter exit, or current in another thread
                self._gl_context.make_current()
        super().close()


def parse_size(text: str) -> tuple[int, int]:
    """Return width and height of ``640x400``.

    Raises:
        BtManipError: If it has another form.
    """
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text, re.ASCII)
    if found is None:
        raise BtManipError(f"size is WIDTHxHEIGHT, such as 640x400, got '{text}'")
    return int(found[1]), int(found[2])


def camera_number(model: mujoco.MjModel, name: str) -> int:
    """Return the number of a camera.

    Args:
        model: The compiled model.
        name: Full name of the camera in it.

    Raises:
        CellError: If there is no such camera; the nearest names are suggested.
    """
    names = [model.camera(i).name for i in range(model.ncam)]
    if name not in names:
        raise CellError(f"there is no camera '{name}'{did_you_mean(name, names)}")
    return names.index(name)


def render(
    cell: "Cell", camera: str = "overview", *, width: int = 1280, height: int = 800
) -> np.ndarray:
    """Return an image of a camera of the cell; the cell does not change.

    Args:
        cell: The cell.
        camera: Full name of a camera in it.
        width: Width of the image, up to 1920 in bt-manip's arena [pixels].
        height: Height of the image, up to 1200 in bt-manip's arena [pixels].

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
