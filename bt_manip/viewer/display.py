"""Whether there is a display; asked before mujoco is imported, which decides by it how to draw."""

import os
import sys
import warnings

from bt_manip.exceptions import BtManipError


class NoDisplayError(BtManipError):
    """There is no display to open a window on."""


def require_display() -> None:
    """Try to reach the display here: MuJoCo's viewer would wait for a missing one without end.

    Raises:
        NoDisplayError: When there is none.
    """
    display = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not display:
        raise NoDisplayError("there is no display: neither DISPLAY nor WAYLAND_DISPLAY is set")
    import glfw

    with warnings.catch_warnings():  # glfw warns; the error says it better
        warnings.simplefilter("ignore")
        reached = glfw.init()
    if not reached:
        raise NoDisplayError(f"there is no display: '{display}' cannot be opened")
