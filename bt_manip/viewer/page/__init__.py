"""The page of a run in the browser, its scene by viser (the extra ``view``).

Each name is imported on first use: panels are registered also where viser is not installed.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.viewer.page.camera_panel import CameraPanel as CameraPanel
    from bt_manip.viewer.page.error_plot import ErrorPlot as ErrorPlot
    from bt_manip.viewer.page.gui import Gui as Gui
    from bt_manip.viewer.page.gui import GuiElement as GuiElement
    from bt_manip.viewer.page.jog_panel import JogPanel as JogPanel
    from bt_manip.viewer.page.log_panel import BlackboardPanel as BlackboardPanel
    from bt_manip.viewer.page.log_panel import LogPanel as LogPanel
    from bt_manip.viewer.page.overlay_panel import OverlayPanel as OverlayPanel
    from bt_manip.viewer.page.page import Page as Page
    from bt_manip.viewer.page.panel import Panel as Panel
    from bt_manip.viewer.page.perturbation_panel import PerturbationPanel as PerturbationPanel
    from bt_manip.viewer.page.replay_page import ReplayPage as ReplayPage
    from bt_manip.viewer.page.scene import SceneView as SceneView
    from bt_manip.viewer.page.server import PORT as PORT
    from bt_manip.viewer.page.server import close_server as close_server
    from bt_manip.viewer.page.server import open_server as open_server
    from bt_manip.viewer.page.session_panel import RunChoice as RunChoice
    from bt_manip.viewer.page.session_panel import SessionPanel as SessionPanel
    from bt_manip.viewer.page.timeline_panel import TimelinePanel as TimelinePanel
    from bt_manip.viewer.page.tree_panel import NodePanel as NodePanel
    from bt_manip.viewer.page.tree_panel import TreePanel as TreePanel

__getattr__ = lazy_exports(
    __name__,
    {
        "bt_manip.viewer.page.camera_panel": "CameraPanel",
        "bt_manip.viewer.page.error_plot": "ErrorPlot",
        "bt_manip.viewer.page.gui": "Gui GuiElement",
        "bt_manip.viewer.page.jog_panel": "JogPanel",
        "bt_manip.viewer.page.log_panel": "BlackboardPanel LogPanel",
        "bt_manip.viewer.page.overlay_panel": "OverlayPanel",
        "bt_manip.viewer.page.page": "Page",
        "bt_manip.viewer.page.panel": "Panel",
        "bt_manip.viewer.page.perturbation_panel": "PerturbationPanel",
        "bt_manip.viewer.page.replay_page": "ReplayPage",
        "bt_manip.viewer.page.scene": "SceneView",
        "bt_manip.viewer.page.server": "PORT close_server open_server",
        "bt_manip.viewer.page.session_panel": "RunChoice SessionPanel",
        "bt_manip.viewer.page.timeline_panel": "TimelinePanel",
        "bt_manip.viewer.page.tree_panel": "NodePanel TreePanel",
    },
)
