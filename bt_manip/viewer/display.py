"""Check for a display, before mujoco is imported: MUJOCO_GL is read at its import."""

import ctypes.util
import os
import sys
import warnings

from bt_manip.exceptions import BtManipError


def use_offscreen_opengl() -> None:
    """Select an offscreen OpenGL backend, unless MUJOCO_GL names one."""
    if sys.platform.startswith("linux"):
        for backend, library in (("egl", "EGL"), ("osmesa", "OSMesa")):
            if ctypes.util.find_library(library):
                os.environ.setdefault("MUJOCO_GL", backend)


class NoDisplayError(BtManipError):
    """No display is available for a window."""


def require_display() -> None:
    """Raise a `NoDisplayError` without a display, for which MuJoCo's viewer would wait forever."""
    display = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not display:
        raise NoDisplayError("there is no display: neither DISPLAY nor WAYLAND_DISPLAY is set")
    import glfw

    with warnings.catch_warnings():  # the error replaces the warning of glfw
        warnings.simplefilter("ignore")
        reached = glfw.init()
    if not reached:
        raise NoDisplayError(f"there is no display: '{display}' cannot be opened")
