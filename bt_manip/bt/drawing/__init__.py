"""Drawing trees: as text for a terminal, as DOT, and as SVG."""

from bt_manip.bt.drawing.dot import draw_dot as draw_dot
from bt_manip.bt.drawing.svg import draw_svg as draw_svg
from bt_manip.bt.drawing.text import draw_text as draw_text
