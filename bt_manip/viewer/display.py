"""Check for a display, before mujoco is imported: MUJOCO_GL is read at its import."""

import os
import sys
import warnings

from bt_manip.exceptions import BtManipError


class NoDisplayError(BtManipError):
    """There is no display to open a window on."""


def require_display() -> None:
    """Connect to the display: without one, MuJoCo's viewer would wait forever.

    Raises:
        NoDisplayError: If there is none.
    """
    display = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not display:
        raise NoDisplayError("there is no display: neither DISPLAY nor WAYLAND_DISPLAY is set")
    import glfw

    with warnings.catch_warnings():  # the error replaces the warning of glfw
        warnings.simplefilter("ignore")
        reached = glfw.init()
    if not reached:
        raise NoDisplayError(f"there is no display: '{display}' cannot be opened")
