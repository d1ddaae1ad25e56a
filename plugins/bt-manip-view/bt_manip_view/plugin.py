"""What the package brings; everything expensive is imported when it is needed."""

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from bt_manip import hookimpl
from bt_manip.parameters import Parameter
from bt_manip_view.hooks import register_panels as register_panels

if TYPE_CHECKING:
    from bt_manip.cli import Session
    from bt_manip_view.page_view import PageView

VIEW = "view"
"""Name of the view, whose option is ``--view``, and of this plugin."""

PANELS = {
    "tree": "tree_panel:TreePanel",
    "results": "results_panel:ResultsPanel",
    "timeline": "timeline_panel:TimelinePanel",
    "node": "tree_panel:NodePanel",
    "log": "log_panel:LogPanel",
    "plots": "plot_panel:PlotPanel",
    "blackboard": "log_panel:BlackboardPanel",
    "overlays": "overlay_panel:OverlayPanel",
    "pull": "perturbation_panel:PerturbationPanel",
    "camera": "camera_panel:CameraPanel",
}
"""Module in ``page`` and class of each panel, by its name, in the order on the page."""


def view(
    session: "Session",
    *,
    port: Annotated[
        int,
        Parameter("First port that is tried; 0 lets the system choose.", at_least=0, at_most=65535),
    ] = 8080,
    breakpoints: Annotated[
        str | None,
        Parameter(
            "Names or paths of nodes, separated by ';', at whose start the run pauses.", type=str
        ),
    ] = None,
) -> "PageView":
    """Show the run on a page in the browser, which stays up after the run."""
    from bt_manip_view.page.breakpoints import split_names
    from bt_manip_view.page_view import PageView

    return PageView(session, port, split_names(breakpoints or ""))


view.controls_runs = True  # type: ignore[attr-defined]


@hookimpl
def register_views(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the page."""
    register(VIEW, view)


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip view``, ``replay`` and ``report``."""
    for name in ("view", "replay", "report"):
        register(name, f"bt_manip_view.commands.{name}:{name}")


@hookimpl(specname="register_panels")
def register_own_panels(register: Callable[[str, Callable[[Any], Any]], None]) -> None:
    """Register the panels of the page."""
    for name, place in PANELS.items():
        module, _, panel = place.partition(":")
        register(name, getattr(importlib.import_module(f"bt_manip_view.page.{module}"), panel))


@hookimpl
def register_recorders(register: Callable[[str, Callable[[Path | None], Any]], None]) -> None:
    """Register videos of runs."""
    from bt_manip_view.video import VideoRecorder

    register("video", VideoRecorder)


@hookimpl(optionalhook=True)
def register_export_formats(register: Callable[[str, Callable[..., None]], None]) -> None:
    """Register videos of recordings."""
    from bt_manip_view.video import write_video

    for suffix in ("mp4", "gif"):
        register(suffix, write_video)
