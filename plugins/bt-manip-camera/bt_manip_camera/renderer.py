"""A renderer that is kept when objects are added and removed."""

import weakref
import zlib
from contextlib import suppress

import mujoco
import numpy as np

from bt_manip.cell import FrameRenderer

_UPLOADED = (
    "tex_data", "mesh_vert", "mesh_normal", "mesh_texcoord", "mesh_face", "hfield_data",
    "skin_vert", "flex_vert",
)  # fmt: skip
_MATERIALS = ("mat_texid", "mat_texuniform", "mat_texrepeat")
_MAX_GEOMS = 10_000

SETS = 2
"""Sets of meshes and textures that are kept."""


class KeptRenderer:
    """Renders colour and depth without shadows, reflections and antialiasing.

    The graphics context, which costs more than the images, holds the meshes and textures of a
    model. It is kept for other models with the same ones; of different sets, those of the last
    `SETS` are kept, as an object with a texture of its own comes and goes.

    Args:
        width: Width of the images [pixels].
        height: Height of the images [pixels].

    Attributes:
        contexts: The graphics contexts that it has, the last used one last.
    """

    def __init__(self, width: int, height: int) -> None:
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._model: mujoco.MjModel | None = None
        self._option = mujoco.MjvOption()
        self._gl = mujoco.GLContext(width, height)
        self.contexts: dict[int, mujoco.MjrContext] = {}
        self.close = weakref.finalize(self, _free, self._gl, self.contexts)  # also at exit
        """Free the graphics context."""

    def render(
        self, model: mujoco.MjModel, data: mujoco.MjData, camera: int, site: int | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return colour and depth of a state, which does not change.

        Args:
            model: The compiled model.
            data: The state; poses are computed from the joint positions.
            camera: Number of the camera in the model.
            site: Number of a site; the camera's pose in the model is then that in the frame of
                the site. None: it is that in the world.

        Returns:
            Red, green and blue from 0 to 255, and the distance along the camera's axis [m], the
            top row first.  # (height, width, 3) uint8, (height, width)
        """
        self._show(model)
        state = self._data
        mujoco.mj_copyData(state, model, data)
        mujoco.mj_fwdPosition(model, state)
        if site is not None:
            turn = state.site_xmat[site].reshape(3, 3)
            state.cam_xpos[camera] = state.site_xpos[site] + turn @ state.cam_xpos[camera]
            state.cam_xmat[camera] = (turn @ state.cam_xmat[camera].reshape(3, 3)).ravel()
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        view = mujoco.MjvCamera()
        view.type, view.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, camera
        everything = int(mujoco.mjtCatBit.mjCAT_ALL)
        scene = self._scene
        mujoco.mjv_updateScene(model, state, self._option, None, view, everything, scene)
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            scene.flags[flag] = 0
        height, width = self._rect.height, self._rect.width
        colour = np.empty((height, width, 3), np.uint8)
        buffer = np.empty((height, width), np.float32)
        mujoco.mjr_render(self._rect, scene, self._context)
        mujoco.mjr_readPixels(colour, buffer, self._rect, self._context)
        return colour[::-1].copy(), _metres(model, buffer[::-1])

    def _show(self, model: mujoco.MjModel) -> None:
        """Prepare a model for rendering."""
        self._gl.make_current()
        if self._model is model:
            return
        key = 0
        for name in _UPLOADED:
            key = zlib.crc32(np.ascontiguousarray(getattr(model, name)).tobytes(), key)
        context = self.contexts.pop(key, None) or self._upload(model)
        self.contexts[key] = self._context = context
        while len(self.contexts) > SETS:
            self.contexts.pop(next(iter(self.contexts))).free()
        for name in _MATERIALS:
            values = getattr(model, name).ravel()
            getattr(context, name).ravel()[: values.size] = values
        self._model, self._data = model, mujoco.MjData(model)
        self._scene = mujoco.MjvScene(model, _MAX_GEOMS)

    def _upload(self, model: mujoco.MjModel) -> mujoco.MjrContext:
        """Return a graphics context with the meshes and textures of a model."""
        quality, size = model.vis.quality, model.vis.global_
        kept = quality.shadowsize, quality.offsamples, size.offwidth, size.offheight
        quality.shadowsize, quality.offsamples = 16, 0  # the minimum of a context
        size.offwidth, size.offheight = self._rect.width, self._rect.height
        try:
            context = mujoco.MjrContext(model, int(mujoco.mjtFontScale.mjFONTSCALE_50))
        finally:
            quality.shadowsize, quality.offsamples, size.offwidth, size.offheight = kept
        context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        return context


def _free(gl: "mujoco.GLContext", contexts: dict[int, mujoco.MjrContext]) -> None:
    """Free an OpenGL context and its graphics contexts."""
    with suppress(Exception):  # current in another thread, or at the interpreter's exit
        gl.make_current()
        while contexts:
            contexts.popitem()[1].free()
        gl.free()


def check_opengl() -> None:
    """Check that something can be rendered.

    Raises:
        NoOpenGLError: If no OpenGL backend works.
    """
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    FrameRenderer(model, 1, 1).close()


def _metres(model: mujoco.MjModel, buffer: np.ndarray) -> np.ndarray:
    """Return the distances along the camera's axis of a depth buffer with zero at infinity [m].

    With near and far planes n and f, the buffer holds n (f - d) / (d (f - n)).
    """
    near = model.vis.map.znear * model.stat.extent
    far = model.vis.map.zfar * model.stat.extent
    return near * far / (near + buffer.astype(float) * (far - near))
