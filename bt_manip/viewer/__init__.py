"""Views of a run: in the terminal, or in a window.

Each name is imported when it is first used: a window needs OpenGL, the terminal does not.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.cell import NoOpenGLError as NoOpenGLError
    from bt_manip.cell import render as render
    from bt_manip.cell import write_png as write_png
    from bt_manip.viewer.display import NoDisplayError as NoDisplayError
    from bt_manip.viewer.display import require_display as require_display
    from bt_manip.viewer.display import use_offscreen_opengl as use_offscreen_opengl
    from bt_manip.viewer.plain_view import PlainView as PlainView
    from bt_manip.viewer.progress import duration_text as duration_text
    from bt_manip.viewer.terminal_view import TerminalView as TerminalView
    from bt_manip.viewer.window import FREE_CAMERA as FREE_CAMERA
    from bt_manip.viewer.window import Window as Window
    from bt_manip.viewer.wrapping import print_wrapped as print_wrapped

__getattr__ = lazy_exports(__name__)
