"""Runs and recordings of bt-manip in the browser, as HTML and as videos.

Names are imported on first use: a panel needs neither the server of the page nor a video encoder.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip_view.html.recorded_run_page import run_page as run_page
    from bt_manip_view.html.success_page import results_page as results_page
    from bt_manip_view.page.page import Page as Page
    from bt_manip_view.page.panel import Panel as Panel
    from bt_manip_view.page.replay_page import ReplayPage as ReplayPage
    from bt_manip_view.page.saved_configurations import save_configuration as save_configuration
    from bt_manip_view.video.export_video import write_video as write_video
    from bt_manip_view.video.video_recorder import VideoRecorder as VideoRecorder

__getattr__ = lazy_exports(__name__)
