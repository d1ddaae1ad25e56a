"""The page of a run in the browser.

Names that need viser (the extra ``view``) are imported on first use; panels do not need it.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

from .camera_panel import CameraPanel as CameraPanel
from .error_plot import ErrorPlot as ErrorPlot
from .gui import Gui as Gui
from .gui import GuiElement as GuiElement
from .jog_panel import JogPanel as JogPanel
from .log_panel import BlackboardPanel as BlackboardPanel
from .log_panel import LogPanel as LogPanel
from .overlay_panel import OverlayPanel as OverlayPanel
from .panel import Panel as Panel
from .perturbation_panel import PerturbationPanel as PerturbationPanel
from .session_panel import RunChoice as RunChoice
from .session_panel import SessionPanel as SessionPanel
from .timeline_panel import TimelinePanel as TimelinePanel
from .tree_panel import NodePanel as NodePanel
from .tree_panel import TreePanel as TreePanel

if TYPE_CHECKING:
    from bt_manip.viewer.page.page import Page as Page
    from bt_manip.viewer.page.replay_page import ReplayPage as ReplayPage
    from bt_manip.viewer.page.scene import SceneView as SceneView
    from bt_manip.viewer.page.server import PORT as PORT
    from bt_manip.viewer.page.server import close_server as close_server
    from bt_manip.viewer.page.server import open_server as open_server

__getattr__ = lazy_exports(
    __name__,
    {
        "bt_manip.viewer.page.page": "Page",
        "bt_manip.viewer.page.replay_page": "ReplayPage",
        "bt_manip.viewer.page.scene": "SceneView",
        "bt_manip.viewer.page.server": "PORT close_server open_server",
    },
)
